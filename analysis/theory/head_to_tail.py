"""The largest gain from the first vehicle of a string to the last, over all frequencies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from zenvoy.analysis.theory.chain import Member, frequency_response, is_stable
from zenvoy.analysis.theory.laws import Floats, Peak

_DECADES: Final = 4.0
_POINTS: Final = 800  # of the grid: 1.2 % from one frequency to the next
_PEAKS: Final = 4  # of the grid that are looked at closely: a narrow one is lower on the grid
_ZOOMS: Final = 3
_ZOOMED: Final = 41  # points between the neighbours of the best one
_ROUNDING: Final = 1e-9


def head_to_tail(members: Sequence[Member]) -> Peak:
    """Return the largest gain from the first vehicle's speed to the last one's, and its frequency.

    It is 1 at frequency 0, where all vehicles follow the first, and infinite for a string that does
    not come to rest by itself. k_d must be positive.
    """
    if not is_stable(members):
        return Peak(math.inf, 0.0)
    high = 4.0 * max(_fastest(member) for member in members)
    omega = np.geomspace(high * 10.0**-_DECADES, high, _POINTS)
    gain = _gains(omega, members)
    inner = 1 + np.flatnonzero((gain[1:-1] >= gain[:-2]) & (gain[1:-1] >= gain[2:]))
    found = inner[np.argsort(-gain[inner])][:_PEAKS].tolist()
    peaks = [_zoomed(omega[at - 1], omega[at + 1], members) for at in found]
    peak = max(peaks, key=lambda one: one.gain, default=Peak(1.0, 0.0))
    return peak if peak.gain > 1.0 + _ROUNDING else Peak(1.0, 0.0)


def _zoomed(low: float, high: float, members: Sequence[Member]) -> Peak:
    """Return the peak between two frequencies."""
    for _ in range(_ZOOMS):
        omega = np.linspace(low, high, _ZOOMED)
        gain = _gains(omega, members)
        best = int(np.argmax(gain))
        low, high = omega[max(0, best - 1)], omega[min(best + 1, _ZOOMED - 1)]
    return Peak(float(gain[best]), float(omega[best]))


def _gains(omega: Floats, members: Sequence[Member]) -> Floats:
    return np.abs(frequency_response(omega, members, 0, ring=False)[:, -1])


def _fastest(member: Member) -> float:
    """Return a frequency, rad/s, beyond which the vehicle follows nobody."""
    coupling, gains, *_ = member
    if coupling is None:
        return 0.0
    weight = sum(coupling.ahead) + sum(coupling.behind)
    return abs(weight * gains.k_v) + abs(gains.k_c) + math.sqrt(abs(weight * gains.k_d))
