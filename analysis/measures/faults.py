"""The faults of a run, and what each of them cost. Everything comes from the log."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.measures.safety import smallest, time_to_collision
from zenvoy.bus import messages_pb2 as pb
from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]

AFTER_S: Final = 10.0
"""How long after its end a fault still counts, s."""


class FaultSpan(NamedTuple):
    """A fault, in words, its vehicles (1..n), and when it was in force, s.

    A fault that outlasts the run ends at infinity.
    """

    text: str
    vehicles: tuple[int, ...]
    start_s: float
    end_s: float


class Stretch(NamedTuple):
    """The worst of a stretch of a run, over all vehicles.

    gap_m: smallest gap, from front to front, and behind it the vehicle whose gap it is.
    collision_time_s: smallest time to collision; infinite if no gap closes. slower_mps: largest
    loss of a vehicle's speed since the begin of the stretch.
    """

    gap_m: float
    vehicle: int
    collision_time_s: float
    slower_mps: float
    collisions: int


class Cost(NamedTuple):
    """The worst while a fault was in force and AFTER_S after it, and in as long before it.

    before: None if the fault begins with the run. Both stretches are cut at the ends of the run.
    """

    fault: FaultSpan
    before: Stretch | None
    during: Stretch


class Moves(NamedTuple):
    """True motion: times (T,), s, and positions (T, n), m, speeds (T, n), m/s.

    length_m: length of a vehicle. ring_length_m: None on the open road.
    """

    time_s: Floats
    position: Floats
    speed: Floats
    length_m: float
    ring_length_m: float | None


def fault_spans(events: Sequence[pb.Event]) -> list[FaultSpan]:
    """Return the faults of a run in order of their begin; one that hits a set of vehicles is one.

    Events with the same text, begin and end belong to the same fault.
    """
    found: dict[tuple[float, float, str], list[int]] = {}
    ends_s: dict[tuple[int, str], float] = {}  # the next one by vehicle and text
    for event in reversed(events):
        at_s, of = event.time_ns * 1e-9, (event.vehicle, event.text)
        if event.kind == pb.EVENT_FAULT_END:
            ends_s[of] = at_s
        elif event.kind == pb.EVENT_FAULT:
            found.setdefault((at_s, ends_s.get(of, math.inf), event.text), []).append(event.vehicle)
    return [
        FaultSpan(text, tuple(reversed(vehicles)), start_s, end_s)
        for (start_s, end_s, text), vehicles in sorted(found.items())
    ]


def costs(events: Sequence[pb.Event], moves: Moves) -> list[Cost]:
    """Return what each fault that began within the run cost, in order of their begin."""
    faults = fault_spans(events)
    if not faults:
        return []
    gap = gaps(moves.position, moves.ring_length_m)
    ttc = time_to_collision(gap, moves.speed, moves.length_m, moves.ring_length_m)
    collided_s = [e.time_ns * 1e-9 for e in events if e.kind == pb.EVENT_COLLISION]

    def stretch(low_s: float, high_s: float) -> Stretch | None:
        within = (moves.time_s >= low_s - 1e-9) & (moves.time_s <= high_s + 1e-9)
        if not within.any():
            return None
        of_each = np.fmin.reduce(gap[within], axis=0)
        speed = moves.speed[within]
        return Stretch(
            gap_m=float(np.fmin.reduce(of_each)),
            vehicle=int(np.nanargmin(of_each)) + 1,
            collision_time_s=float(smallest(ttc[within]).min()),
            slower_mps=float((speed[0] - speed).max()),
            collisions=sum(low_s <= at_s <= high_s for at_s in collided_s),
        )

    last_s = float(moves.time_s[-1])
    found = []
    for fault in faults:
        end_s = min(fault.end_s + AFTER_S, last_s)
        during = stretch(fault.start_s, end_s)
        if during is not None:
            before_s = max(0.0, fault.start_s - (end_s - fault.start_s))
            before = stretch(before_s, fault.start_s) if fault.start_s > 0.0 else None
            found.append(Cost(fault, before, during))
    return found
