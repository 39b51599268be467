"""Notes on events that never happen, and on speeds that no vehicle can follow."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.events import Brake, Sine, Trace
from zenvoy.values.section import NS_PER_S
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario

# A start this close to the first point needs no note.
_NEAR_MPS: Final = 1.0
_ROUNDING: Final = 1.0 + 1e-6


def notes_of_events(scenario: Scenario) -> Iterator[Problem]:
    """Yield the notes on the events of a valid scenario, without places."""
    end_ns = scenario.cycles * scenario.period_ns
    expected = _Expected(scenario)
    in_order = sorted(enumerate(scenario.events), key=lambda entry: entry[1].start_ns)
    for index, event in in_order:
        key = f"events.{index}"
        if event.start_ns >= end_ns:
            yield _never(event, key, end_ns)
        elif not isinstance(event, Brake):
            yield from _steep(event, key, expected.speeds_mps(event.vehicle), scenario)
        expected.add(event)


def _never(event: Brake | Sine | Trace, key: str, end_ns: int) -> Problem:
    start, end = (trimmed(round(t / NS_PER_S, 9)) for t in (event.start_ns, end_ns))
    text = f"begins at {start} s, but the run ends at {end} s"
    if isinstance(event, Trace) and event.points[0][0] > 0:
        first = trimmed(event.points[0][0])
        text += f": its times begin at {first}; time: from-first counts the times of a file from 0"
    return Problem(key=f"{key}.at_s", text=text, related=(key, "duration_s"))


class _Expected:
    """The approximate range of speeds of each vehicle after the events added so far."""

    def __init__(self, scenario: Scenario) -> None:
        fleet, control = scenario.fleet, scenario.control
        self._first_keeps = scenario.road.type == "open"
        self._start_mps = fleet.speeds_at_start_mps[0]
        speeds = [control.desired_speed_mps]
        speeds += [group.desired_speed_mps or 0.0 for group in fleet.groups]
        speeds += [switch.desired_speed_mps or 0.0 for switch in control.schedule]
        changes = any(switch.desired_speed_mps is not None for switch in control.schedule)
        speeds += fleet.speeds_at_start_mps
        self._desired_mps = (min(speeds), max(speeds))
        self._changes = changes
        self._span_mps: dict[int, tuple[float, float]] = {}

    def speeds_mps(self, vehicle: int) -> tuple[float, float]:
        """Return the lowest and the highest speed that a vehicle may have."""
        if vehicle == 1 and self._first_keeps and not self._changes:
            return self._span_mps.get(1, (self._start_mps, self._start_mps))
        low, high = self._desired_mps
        other_low, other_high = self._span_mps.get(vehicle, (low, high))
        return min(low, other_low), max(high, other_high)

    def add(self, event: Brake | Sine | Trace) -> None:
        """Add an event; events must come in order of time."""
        low, high = self.speeds_mps(event.vehicle)
        if isinstance(event, Trace):
            low = high = event.points[-1][1]
        elif isinstance(event, Sine):
            low, high = event.mean_mps - event.amplitude_mps, event.mean_mps + event.amplitude_mps
        else:
            low = max(0.0, low - event.deceleration_mps2 * event.duration_s)
        self._span_mps[event.vehicle] = (low, high)


def _steep(
    event: Sine | Trace, key: str, speeds_mps: tuple[float, float], scenario: Scenario
) -> Iterator[Problem]:
    """Note if the vehicle cannot meet the first point, or if the limit does not allow a slope."""
    limit = scenario.control.acceleration_limit_mps2
    allowed = f"control.acceleration_limit_mps2 ({trimmed(limit)})"
    related = (f"{key}.type", key, "control.acceleration_limit_mps2")
    where = f"{key}.points" if isinstance(event, Trace) else f"{key}.amplitude_mps"
    first_mps, second_mps, span_s = _begin(event, scenario.period_ns * 1e-9)
    here_mps = min(max(first_mps, speeds_mps[0]), speeds_mps[1])
    about = f"the vehicle has about {trimmed(round(here_mps, 3))} m/s"
    jump = (second_mps - here_mps) / span_s
    if abs(jump) > limit * _ROUNDING and abs(here_mps - first_mps) > 1e-6:
        text = f"needs {jump:.3g} m/s² in its first {span_s:.3g} s, because {about} at its start"
        text += f" instead of {trimmed(first_mps)}; this is more than {allowed}"
        yield Problem(key=where, text=text, related=related)
    elif abs(here_mps - first_mps) > _NEAR_MPS:
        text = f"the speed misses its first point, {trimmed(first_mps)} m/s: {about} then"
        yield Problem(key=where, text=text, related=("fleet.speed_mps", *related))
    steepest, at_s = _steepest(event)
    if abs(steepest) > limit * _ROUNDING:
        text = f"needs {steepest:.3g} m/s² at {at_s:.6g} s, more than {allowed}"
        yield Problem(key=where, text=text, related=related)


def _begin(event: Sine | Trace, period_s: float) -> tuple[float, float, float]:
    """Return the first two speeds, m/s, and the time between them, s."""
    if isinstance(event, Trace):
        (first_s, first_mps), (second_s, second_mps) = event.points[:2]
        return first_mps, second_mps, second_s - first_s
    swing = math.sin(2 * math.pi * event.frequency_hz * period_s)
    return event.mean_mps, event.mean_mps + event.amplitude_mps * swing, period_s


def _steepest(event: Sine | Trace) -> tuple[float, float]:
    """Return the strongest acceleration of the profile, m/s², and its time, s."""
    if isinstance(event, Trace):
        slopes = [
            ((b - a) / (until_s - from_s), event.at_s + from_s)
            for (from_s, a), (until_s, b) in pairwise(event.points)
        ]
        return max(slopes, key=lambda found: abs(found[0]))
    fastest_hz = max(event.frequency_hz, event.to_frequency_hz or 0.0)
    return 2 * math.pi * fastest_hz * event.amplitude_mps, event.at_s
