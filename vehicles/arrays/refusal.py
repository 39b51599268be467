"""What the array engine cannot run."""


class NotCoveredError(Exception):
    """Raised where a run needs what the array engine does not have; its text names it."""
