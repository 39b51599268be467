"""From the file of a log to arrays: its records, its checks, its repair, a run as one value."""
