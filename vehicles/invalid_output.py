"""Says why the output of a law is not valid; `decision.applied` finds out whether it is."""

from __future__ import annotations

from math import isfinite

from zenvoy.laws import Law, Output
from zenvoy.laws.errors import shortened


def why_invalid(output: Output, law: Law) -> str:
    """Return what is wrong with an invalid output, in a few words."""
    if not _are_finite((output.acceleration,)):
        return f"{shortened(output.acceleration)}, which is no acceleration"
    if not _are_finite(output.state) or len(output.state) != len(law.state):
        return f"{shortened(output.state)} as its state, not {_tuple_of(len(law.state))}"
    return f"{shortened(output.logged)} to be logged, not {_tuple_of(len(law.columns))}"


def _are_finite(values: object) -> bool:
    if not isinstance(values, tuple | list):
        return False
    try:
        return all(map(isfinite, values))
    except TypeError:
        return False


def _tuple_of(count: int) -> str:
    return f"a tuple of {count} number{'' if count == 1 else 's'}"
