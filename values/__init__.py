"""The types of values in a scenario, and how messages show values."""
