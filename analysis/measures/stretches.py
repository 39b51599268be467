"""The stretches of a run that are linear: nobody stands, few are at their limits, none collides."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.spans import Disturbance, disturbances
from zenvoy.bus import messages_pb2 as pb

_STANDING: Final = "some vehicle stands"
_LIMITED: Final = "many vehicles are at their acceleration limits"
_STANDS_MPS: Final = 0.1
_LONG_S: Final = 10.0  # a shorter stretch tells little of waves that take seconds per vehicle
_NEARLY: Final = 0.999  # of the limit
_MANY: Final = 0.05  # of all vehicles
_AFTER_S: Final = 5.0  # a hard braking may drive its neighbours to their limits, too


class Stretch(NamedTuple):
    """Rows [low, high). `from_start`: it begins with the disturbance, out of a settled fleet."""

    low: int
    high: int
    from_start: bool

    @property
    def rows(self) -> int:
        """How many."""
        return self.high - self.low


def stretches(run: Run, first: Disturbance) -> tuple[list[Stretch], list[str]]:
    """Linear stretches after the first disturbance, and in words what lies between and after them.

    Where nobody stands, nor many are at their limits, there is one, up to what ends it for good.
    Of those after that, only the ones of 10 s and more count.
    """
    low, high, notes = _window(run, first)
    stands = run.truth["speed"][low:high].min(axis=1) < _STANDS_MPS
    at_limit = _many_at_limit(run, first)[low:high]
    if not (stands | at_limit).any():
        return [Stretch(low, high, from_start=True)], notes
    linear = np.concatenate([[False], ~(stands | at_limit), [False]])
    edges = np.flatnonzero(np.diff(linear.astype(np.int8)))
    pieces = [
        Stretch(low + int(start), low + int(end), from_start=start == 0)
        for start, end in edges.reshape(-1, 2)
    ]
    least = round(_LONG_S * 1e9 / run.scenario.period_ns)
    long = [piece for piece in pieces if piece.rows >= least]
    kept = long or [piece for piece in pieces if piece.from_start]
    why = [_STANDING] * bool(stands.any()) + [_LIMITED] * bool(at_limit.any())
    return kept, [*notes, f"At times {' or '.join(why)}, which is not linear. {_told(run, long)}"]


def main_stretch(found: list[Stretch]) -> Stretch | None:
    """The one to be told of: that from the disturbance on if there is one, or else the longest."""
    return max(found, key=lambda stretch: (stretch.from_start, stretch.rows), default=None)


def _told(run: Run, long: list[Stretch]) -> str:
    spans = [f"from {run.time_s[one.low]:g} s to {run.time_s[one.high - 1]:g} s" for one in long]
    if spans:
        return f"What is linear: {' and '.join(spans)}."
    return f"What lies between lasts for less than {_LONG_S:g} s."


def _window(run: Run, first: Disturbance) -> tuple[int, int, list[str]]:
    """Rows from the disturbance to what ends all that is linear, or of it."""
    time_s = run.time_s
    ends = [(float(time_s[-1]) + 1.0, "")]
    for event in run.events:
        at_s = event.time_ns * 1e-9
        if event.kind == pb.EVENT_COLLISION and at_s > first.start_s:
            ends.append((at_s, f"a collision of vehicle {event.vehicle}"))
        if event.kind == pb.EVENT_MODEL and at_s > first.start_s:
            ends.append((at_s, f"the switch to {event.text}"))
        if event.kind == pb.EVENT_TARGET and at_s > first.start_s:
            ends.append((at_s, f"the change to {event.text}"))
    for other in disturbances(run.events):
        if other.vehicle != first.vehicle:
            ends.append((other.start_s, f"the disturbance of vehicle {other.vehicle}"))
    end_s, why = min(ends)
    low = int(np.searchsorted(time_s, first.start_s - 1e-9))
    high = int(np.searchsorted(time_s, end_s - 1e-9))
    notes = [f"What came after {end_s:g} s is left out: {why}."] if why else []
    return low, high, notes


def _many_at_limit(run: Run, first: Disturbance) -> NDArray[np.bool_]:
    """Rows (T,) after the disturbance at which so many have been at their limits for a second."""
    limit = run.scenario.control.acceleration_limit_mps2 * _NEARLY
    at_limit: NDArray[np.int64] = (np.abs(run.truth["acceleration"]) >= limit).sum(axis=1)
    rows = max(1, round(1.0 / (run.scenario.period_ns * 1e-9)))
    mean = np.convolve(at_limit, np.ones(rows) / rows)[: len(at_limit)]
    many = mean > max(1.5, _MANY * run.vehicles)
    return np.asarray(many & (run.time_s > first.end_s + _AFTER_S))
