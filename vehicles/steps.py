"""Step functions of time: accelerations that are constant between given instants.

The acceleration of a step is a float or an array of floats; the arithmetic is the same.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any, Final

NS: Final = 1e-9

Spans = list[tuple[float, int]]
"""Parts of a span of time, in order: the length of each (s), and the index of its step."""

Number = Any
"""A float, or an array of floats."""


def spans(starts_ns: Sequence[int], t0_ns: int, t1_ns: int) -> Spans:
    """Return the parts of [t0, t1] in steps that begin at `starts_ns`, in ascending order.

    The first step has no beginning, and the last one has no end.
    """
    if t0_ns >= starts_ns[-1]:  # nearly always: nothing changes after t0
        return [((t1_ns - t0_ns) * NS, len(starts_ns) - 1)]
    at = max(bisect_right(starts_ns, t0_ns) - 1, 0)
    parts, now = [], t0_ns
    while now < t1_ns:
        following = starts_ns[at + 1] if at + 1 < len(starts_ns) else t1_ns
        until = min(following, t1_ns)
        parts.append(((until - now) * NS, at))
        now = until
        at += 1
    return parts


def over(parts: Spans, values: Sequence[Number]) -> tuple[Number, Number]:
    """Return displacement beyond uniform motion (m) and change of speed (m/s) over the parts."""
    if len(parts) == 1:
        dt, at = parts[0]
        return steady(values[at], dt)
    dp: Number = 0.0
    dv: Number = 0.0
    for dt, at in parts:
        dp, dv = after(dp, dv, values[at], dt)
    return dp, dv


def steady(a: Number, dt: float) -> tuple[Number, Number]:
    """Return displacement beyond uniform motion (m) and change of speed (m/s) in dt (s)."""
    return 0.5 * a * dt * dt, a * dt


def after(dp: Number, dv: Number, a: Number, dt: float) -> tuple[Number, Number]:
    """Return displacement (m) and change of speed (m/s) after dt (s) more of acceleration a."""
    return dp + (dv * dt + 0.5 * a * dt * dt), dv + a * dt
