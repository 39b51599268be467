"""The schema of a scenario: typed sections, checks across them, and derived values."""
