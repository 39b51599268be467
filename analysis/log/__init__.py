"""Reads, checks, repairs and exports logs, and loads a run as one value."""
