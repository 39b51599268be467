"""The command line: runs fleets, watches them, tells what came of it."""
