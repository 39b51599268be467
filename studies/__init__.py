"""Studies: many runs, several at a time, each kept as a digest."""
