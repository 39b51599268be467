"""Tuning: searches for the settings of a scenario that are best by a measure, under constraints."""
