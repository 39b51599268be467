"""Random numbers keyed by seed, purpose, vehicles and number, never by order of arrival."""
