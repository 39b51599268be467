"""Checks of events against the fleet, the period and each other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.events import Sine, Trace
from zenvoy.values.section import NS_PER_S
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario

# 100 minutes at ten points per second: as many as a YAML file of at most 200,000 values can hold.
_MOST_POINTS = 60_000


def events_that_disagree(scenario: Scenario) -> Iterator[Problem]:
    """Yield every disagreement of events, without places."""
    size = scenario.fleet.size
    for index, event in enumerate(scenario.events):
        key = f"events.{index}"
        if event.vehicle > size:
            text = f"{event.vehicle} is not in [1, {size}], the vehicles of fleet.size ({size})"
            yield Problem(key=f"{key}.vehicle", text=text, related=("fleet.size",))
        if isinstance(event, Sine):
            yield from _sine(event, key, scenario.period_ns)
        elif isinstance(event, Trace):
            yield from _trace(event, f"{key}.points")
    yield from _overlaps(scenario)


def _sine(sine: Sine, key: str, period_ns: int) -> Iterator[Problem]:
    """Check that the speed is never below 0, and that the period can resolve the oscillation."""
    if sine.amplitude_mps > sine.mean_mps:
        most = trimmed(sine.mean_mps)
        text = f"{trimmed(sine.amplitude_mps)} is not in [0, {most}], up to mean_mps ({most})"
        yield Problem(key=f"{key}.amplitude_mps", text=text, related=(f"{key}.mean_mps",))
    nyquist_hz = NS_PER_S / (2 * period_ns)
    for name in ("frequency_hz", "to_frequency_hz"):
        value = getattr(sine, name)
        if value is not None and value >= nyquist_hz:
            limit = f"{trimmed(nyquist_hz)}, half the rate of period_ms"
            text = f"{trimmed(value)} is not less than {limit} ({trimmed(period_ns / 1e6)})"
            yield Problem(key=f"{key}.{name}", text=text, related=("period_ms",))


def _trace(trace: Trace, key: str) -> Iterator[Problem]:
    count = len(trace.points)
    if not 2 <= count <= _MOST_POINTS:
        text = f"a list of {count} is not a list of 2 to {_MOST_POINTS} points"
        yield Problem(key=key, text=text)
    # Compare in ns, as the run does, where times that differ by less are equal.
    for index, ((before_s, _), (time_s, _)) in enumerate(pairwise(trace.points), start=1):
        if round(time_s * NS_PER_S) <= round(before_s * NS_PER_S):
            text = f"{trimmed(time_s)} is not later than the point before ({trimmed(before_s)})"
            related = (f"{key}.{index - 1}.0",)
            yield Problem(key=f"{key}.{index}.0", text=text, related=related)


def _overlaps(scenario: Scenario) -> Iterator[Problem]:
    """Check that no vehicle has to follow two speeds at once."""
    spans = sorted(
        (event.vehicle, event.start_ns, event.end_ns, f"events.{index}")
        for index, event in enumerate(scenario.events)
        if isinstance(event, Sine) or (isinstance(event, Trace) and event.points)
    )
    longest: dict[int, tuple[int, str]] = {}  # by vehicle: the latest end so far, and its key
    for vehicle, start_ns, end_ns, key in spans:
        other_end_ns, other = longest.get(vehicle, (start_ns, key))
        if start_ns < other_end_ns:
            start, end = (trimmed(t / NS_PER_S) for t in (start_ns, other_end_ns))
            text = f"begins at {start} s, before {other} of the same vehicle ends ({end} s)"
            parts = ("vehicle", "at_s", "duration_s", "points")
            related = tuple(f"{name}.{part}" for name in (key, other) for part in parts)
            yield Problem(key=key, text=text, related=related)
        longest[vehicle] = max(longest.get(vehicle, (0, "")), (end_ns, key))
