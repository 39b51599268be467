"""The array engine: many runs of a scenario side by side, in one process and without messages."""
