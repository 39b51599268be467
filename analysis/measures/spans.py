"""The spans of time at which the paper looks: before a braking, its dip, the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb

Floats = NDArray[np.float64]

_SETTLED_S: Final = 5.0  # distances before the braking and at the end are means over this
_DIP_S: Final = 30.0  # after the last braking, the dip is looked for this long

_ENDS: Final = {
    pb.EVENT_BRAKE: pb.EVENT_BRAKE_END,
    pb.EVENT_TRACE: pb.EVENT_TRACE_END,  # of sines too
}


class Span(NamedTuple):
    """Times in (low_s, high_s]. Of a `dip` the extremes count, of others the means."""

    name: str
    low_s: float
    high_s: float

    def rows(self, time_s: Floats) -> NDArray[np.bool_]:
        """Which rows lie in it."""
        return (time_s > self.low_s) & (time_s <= self.high_s)


class Disturbance(NamedTuple):
    """What was done to a vehicle (1..n) whatever its controller said, and when."""

    vehicle: int
    start_s: float
    end_s: float
    text: str
    kind: Literal["brake", "trace"]


def disturbances(events: Sequence[pb.Event]) -> list[Disturbance]:
    """Brakings and traces that a run tells of, in order of their start.

    One that had not ended with the run ends at infinity.
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
    """Before the first disturbance, the dip after the last one, and the end, at `end_s`."""
    found = []
    if disturbed:
        first = min(disturbed, key=lambda one: one.start_s)
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
    """MinDistance and MaxDistance (T,) over a span, m: extremes of a dip, means otherwise.

    None where the run has no row in it.
    """
    within = span.rows(time_s)
    if not within.any():
        return None
    low, high = min_distance[within], max_distance[within]
    if span.name == "dip":
        return float(low.min()), float(high.max())
    return float(low.mean()), float(high.mean())
