"""Turns files and settings into a scenario: YAML, `extends`, tables, places of values."""
