"""From files and settings to a scenario: YAML, `extends`, tables, and where each value stands."""
