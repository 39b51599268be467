"""Finds the stretches of a run in which linear theory applies.

There no vehicle stands, few are at their acceleration limits, and none collides.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.motion import at_limits
from zenvoy.analysis.measures.spacing import FRONTS, spacing_of
from zenvoy.analysis.measures.spans import Disturbance, disturbances
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import roster

_STANDING: Final = "some vehicle stands"
_LIMITED: Final = "many vehicles are at their acceleration limits"
_STANDS_MPS: Final = 0.1
_MIN_STRETCH_S: Final = 10.0  # shorter ones are useless for waves that take seconds per vehicle
_AT_LIMIT: Final = 0.999  # share of the limit from which a vehicle is at it
_MANY: Final = 0.05  # share of all vehicles
_EXEMPT_S: Final = 5.0  # after a hard braking the neighbours may be at their limits


class Stretch(NamedTuple):
    """Rows [low, high). `from_start`: it begins with the disturbance of a settled fleet."""

    low: int
    high: int
    from_start: bool

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.high - self.low


def stretches(run: Run, first: Disturbance) -> tuple[list[Stretch], list[str]]:
    """Return the linear stretches after the first disturbance, and notes on what is left out.

    If no vehicle stands and few are at their limits, there is one stretch. It ends with a
    collision, a new disturbance, or a change of model or targets. Otherwise only stretches of 10 s
    and more count.
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
    least = round(_MIN_STRETCH_S * 1e9 / run.scenario.period_ns)
    long = [piece for piece in pieces if piece.rows >= least]
    kept = long or [piece for piece in pieces if piece.from_start]
    why = [_STANDING] * bool(stands.any()) + [_LIMITED] * bool(at_limit.any())
    note = (
        f"At times {' or '.join(why)}; linear theory does not apply then. {_described(run, long)}"
    )
    return kept, [*notes, note]


def main_stretch(found: list[Stretch]) -> Stretch | None:
    """Return the stretch to report: the one that begins with the disturbance, or the longest."""
    return max(found, key=lambda stretch: (stretch.from_start, stretch.rows), default=None)


def _described(run: Run, long: list[Stretch]) -> str:
    spans = [f"from {run.time_s[one.low]:g} s to {run.time_s[one.high - 1]:g} s" for one in long]
    if spans:
        return f"The motion is linear {' and '.join(spans)}."
    return f"No linear stretch lasts for {_MIN_STRETCH_S:g} s or more."


def _window(run: Run, first: Disturbance) -> tuple[int, int, list[str]]:
    """Return the rows from the disturbance to the first event after which theory does not hold."""
    time_s = run.time_s
    ends = [(float(time_s[-1]) + 1.0, "")]
    for event in run.events:
        at_s = event.time_ns * 1e-9
        if event.kind == pb.EVENT_COLLISION and at_s > first.start_s:
            ends.append((at_s, f"a collision of vehicle {event.vehicle}"))
        if event.kind == pb.EVENT_MODEL and at_s > first.start_s:
            ends.append((at_s, f"the switch to {event.text}"))
        if event.kind == pb.EVENT_TARGET and at_s > first.start_s:
            ends.append((at_s, f"the change to {_change(run, event.text)}"))
    for other in disturbances(run.events):
        if other.vehicle != first.vehicle:
            ends.append((other.start_s, f"the disturbance of vehicle {other.vehicle}"))
    end_s, why = min(ends)
    low = int(np.searchsorted(time_s, first.start_s - 1e-9))
    high = int(np.searchsorted(time_s, end_s - 1e-9))
    notes = [f"The time after {end_s:g} s is left out because of {why}."] if why else []
    return low, high, notes


def _change(run: Run, text: str) -> str:
    """Return a change as the log has it; it says how gaps are measured if the report differs."""
    if spacing_of(run.scenario) == FRONTS:
        return text
    return text.replace("desired gap", "desired front-to-front gap")


def _many_at_limit(run: Run, first: Disturbance) -> NDArray[np.bool_]:
    """Return the rows (T,) at which many vehicles have been at their limits for a second."""
    limits = [one.limits for one in roster(run.scenario)]
    at_limit = at_limits(run.truth["acceleration"], limits, _AT_LIMIT).sum(axis=1)
    rows = max(1, round(1.0 / (run.scenario.period_ns * 1e-9)))
    mean = np.convolve(at_limit, np.ones(rows) / rows)[: len(at_limit)]
    many = mean > max(1.5, _MANY * run.vehicles)
    return np.asarray(many & (run.time_s > first.end_s + _EXEMPT_S))
