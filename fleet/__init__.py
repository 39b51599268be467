"""The runner: one scenario to one run, on processes or in this one."""
