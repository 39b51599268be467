"""Says what is wrong with the output of a law."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any

from zenvoy.laws import Law, Output
from zenvoy.laws.errors import shortened


def flaw_of(output: Output, law: Law) -> str:
    """Return what is wrong with an output that is not valid, in a few words."""
    if not _are_numbers((output.acceleration,), isfinite):
        return f"{shortened(output.acceleration)}, which is no acceleration"
    if not _are_numbers(output.state, isfinite) or len(output.state) != len(law.state):
        return f"{shortened(output.state)} as its state, not {_tuple_of(len(law.state))}"
    return f"{shortened(output.logged)} to be logged, not {_tuple_of(len(law.columns))}"


def _are_numbers(values: object, valid: Callable[[Any], bool]) -> bool:
    if not isinstance(values, tuple | list):
        return False
    try:
        return all(map(valid, values))
    except TypeError:
        return False


def _tuple_of(count: int) -> str:
    return f"a tuple of {count} number{'' if count == 1 else 's'}"
