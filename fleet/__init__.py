"""The runner: it turns one scenario into one run, on processes or in this one."""
