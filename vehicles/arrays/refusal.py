"""The error of the array engine for what it does not run."""


class NotCoveredError(Exception):
    """A run needs something that the array engine lacks; the text names it."""
