"""The command line: it starts runs, shows their progress and prints the results."""
