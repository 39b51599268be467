"""Waits for a command, so that one that ends too early is noticed at once."""

from __future__ import annotations

import subprocess
from typing import Any


def ends_within(command: subprocess.Popen[Any], limit_s: float) -> bool:
    """Return whether a command ends within a time."""
    try:
        command.wait(limit_s)
    except subprocess.TimeoutExpired:
        return False
    return True
