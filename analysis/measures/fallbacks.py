"""Counts how often vehicles fell back to FM on their own radar."""

from __future__ import annotations

from collections.abc import Sequence

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Scenario


def fallbacks(events: Sequence[pb.Event], scenario: Scenario) -> int:
    """Return the number of fallbacks in a run's events.

    A vehicle may start in FM because no beacon has reached it yet. This does not count if beacons
    arrive within beacon_age_limit_ms, because the vehicle has not fallen back from anything.
    """
    begun: dict[int, int] = {}
    count = 0
    for event in events:
        if event.kind == pb.EVENT_FALLBACK:
            count += 1
            begun[event.vehicle] = event.time_ns
        elif event.kind == pb.EVENT_FALLBACK_END:
            at_ns = begun.pop(event.vehicle, scenario.period_ns)
            at_start = at_ns < scenario.period_ns
            count -= at_start and event.time_ns - at_ns <= scenario.beacon_age_limit_ns
    return count
