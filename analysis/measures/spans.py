"""The spans of time that the paper examines: before a braking, its dip, the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb

Floats = NDArray[np.float64]

_SETTLED_S: Final = 5.0  # distances before the braking and at the end are means over this time
_DIP_S: Final = 30.0  # the dip is sought up to this time after the last braking

_ENDS: Final = {
    pb.EVENT_BRAKE: pb.EVENT_BRAKE_END,
    pb.EVENT_TRACE: pb.EVENT_TRACE_END,  # also for sines
}


class Span(NamedTuple):
    """The times (low_s, high_s]. A `dip` is described by extremes, other spans by means."""

    name: str
    low_s: float
    high_s: float

    def rows(self, time_s: Floats) -> NDArray[np.bool_]:
        """Return which rows lie in the span."""
        return (time_s > self.low_s) & (time_s <= self.high_s)


class Disturbance(NamedTuple):
    """A braking or a trace that overrides the controller of a vehicle (1..n) for some time."""

    vehicle: int
    start_s: float
    end_s: float
    text: str
    kind: Literal["brake", "trace"]


def disturbances(events: Sequence[pb.Event]) -> list[Disturbance]:
    """Return the brakings and traces of a run, in order of their start.

    A disturbance that outlasts the run ends at infinity.
    """
    found = []
    for index, event in enumerate(events):
        if event.kind not in _ENDS:
            continue
        end_s = next(
            (
                later.time_ns * 1e-9
                for later in events[index:]
                if later.kind == _ENDS[event.kind] and later.vehicle == event.vehicle
            ),
            math.inf,
        )
        kind: Literal["brake", "trace"] = "brake" if event.kind == pb.EVENT_BRAKE else "trace"
        start_s = event.time_ns * 1e-9
        found.append(Disturbance(event.vehicle, start_s, end_s, event.text, kind))
    return sorted(found, key=lambda disturbance: disturbance.start_s)


def first_disturbance(events: Sequence[pb.Event]) -> Disturbance | None:
    """Return the braking or trace that starts first; None where nothing disturbs the run."""
    return next(iter(disturbances(events)), None)


def spans(disturbed: Sequence[Disturbance], end_s: float) -> list[Span]:
    """Return the spans before the first disturbance, of the dip, and at the run's end `end_s`.

    `disturbed` is in order of start, as `disturbances` returns it.
    """
    found = []
    if disturbed:
        first = disturbed[0]
        first_s, last_s = first.start_s, max(one.end_s for one in disturbed)
        before = "before_braking" if first.kind == "brake" else "before_disturbance"
        found += [
            Span(before, first_s - _SETTLED_S, first_s),
            Span("dip", first_s, last_s + _DIP_S),
        ]
    return [*found, Span("end", end_s - _SETTLED_S, math.inf)]


def distances(
    span: Span, time_s: Floats, min_distance: Floats, max_distance: Floats
) -> tuple[float, float] | None:
    """Reduce MinDistance and MaxDistance (T,) to a span, m: extremes in a dip, else means.

    The result is None where the run has no row in the span.
    """
    within = span.rows(time_s)
    if not within.any():
        return None
    low, high = min_distance[within], max_distance[within]
    if span.name == "dip":
        return float(low.min()), float(high.max())
    return float(low.mean()), float(high.mean())
