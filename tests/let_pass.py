"""Faults that last."""

from __future__ import annotations

import time


def let_pass(duration_s: float) -> None:
    """Let a fault last at least this long: what a test has stopped or cut stays so.

    This is no wait for something to happen. The duration is the fault itself, because the program
    compares it with its limits, and whoever could tell stands still. No test has an upper bound: on
    a busy machine the fault lasts longer, and is the same fault.
    """
    time.sleep(duration_s)  # the program under test must see a fault that lasts this long
