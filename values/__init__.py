"""What a value of a scenario may be, and how messages show it."""
