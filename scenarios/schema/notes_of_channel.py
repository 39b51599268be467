"""Notes on the channel: waits that are too short, rules and outages that cover nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from zenvoy.links.table import distributions
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.sets import members
from zenvoy.scenarios.schema.waits import frame_ms, own_wait_ms
from zenvoy.values.section import NS_PER_S
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.channel import Outage, Rule, Scope
    from zenvoy.scenarios.schema.scenario import Scenario

# Wall time. With less slack, most frames of a fleet in real time miss their decision.
_LEAST_SLACK_MS: Final = 5.0


def notes_of_channel(scenario: Scenario, sets: dict[str, frozenset[int]]) -> Iterator[Problem]:
    """Yield the notes on the channel of a valid scenario, without places."""
    yield from _range(scenario)
    yield from _wait(scenario)
    channel = scenario.channel
    for index, rule in enumerate(channel.rules):
        key = f"channel.rules.{index}"
        yield from _scope(rule, key, scenario, sets)
        if rule.loss is None and rule.latency is None:
            yield Problem(key=key, text="sets neither loss nor latency, so it has no effect")
    for index, outage in enumerate(channel.outages):
        yield from _scope(outage, f"channel.outages.{index}", scenario, sets)


def _range(scenario: Scenario) -> Iterator[Problem]:
    range_m = scenario.channel.radio.range_m
    fleet = scenario.fleet
    if min(fleet.gaps_at_start_m) > range_m:
        gap = f"fleet.gap_m ({trimmed(fleet.gap_m)})"
        if fleet.initial_gaps_m is not None:
            gap = f"the smallest of fleet.initial_gaps_m ({trimmed(min(fleet.initial_gaps_m))})"
        text = f"a range of {trimmed(range_m)} m is less than {gap}: "
        text += "at the start no frame is received"
        key = "channel.technology" if scenario.channel.range_m is None else "channel.range_m"
        yield Problem(key=key, text=text, related=("fleet.gap_m",))


def _wait(scenario: Scenario) -> Iterator[Problem]:
    """Note if frames cannot arrive before the decision of their cycle, or barely in real time."""
    wait_ms = scenario.v2v_wait_ns * 1e-6
    latency, delay_ms = scenario.channel.latency, scenario.channel.radio.delay_ms
    least_ms = distributions()[latency.distribution].least_ms(latency, delay_ms)
    least_ms += frame_ms(scenario.channel)
    deadline_ms = wait_ms or scenario.period_ns * 1e-6
    key = "control.v2v_wait_ms" if wait_ms else "channel.latency"
    related = (
        "channel.latency.distribution",
        "channel.latency",
        "channel.delay_ms",
        "channel.technology",
    )
    own_ms = own_wait_ms(scenario)
    is_default = wait_ms in (0, own_ms)
    hint = "" if is_default else f"; null, the default, gives {trimmed(own_ms)} ms"
    waits = f"{trimmed(wait_ms)} ms" if wait_ms else f"a period ({trimmed(deadline_ms)} ms)"
    slack_ms = (wait_ms - least_ms) / scenario.speed
    if least_ms > deadline_ms:
        text = f"{waits} is less than the least latency ({trimmed(round(least_ms, 3))} ms): every "
        text += f"frame is late, and counts in a later cycle{hint}"
        yield Problem(key=key, text=text, related=related)
    elif scenario.clock == "realtime" and wait_ms and slack_ms < _LEAST_SLACK_MS:
        text = f"{waits} leaves {trimmed(round(slack_ms, 3))} ms of wall time after the first "
        text += f"frames: in real time most of them miss their decision{hint}"
        yield Problem(key=key, text=text, related=("clock", *related))
    yield from _ages(scenario, max(0.0, least_ms - wait_ms))


def _ages(scenario: Scenario, late_ms: float) -> Iterator[Problem]:
    """Note if data are older than the age limit before the next beacon arrives."""
    period_ms = scenario.period_ns * 1e-6
    oldest_ms = (scenario.cycles_per_beacon - 1 + math.ceil(late_ms / period_ms)) * period_ms
    limit_ms = scenario.control.beacon_age_limit_ms
    if oldest_ms > limit_ms:
        text = f"{trimmed(limit_ms)} is less than the age of data when the next beacon arrives "
        text += f"({trimmed(round(oldest_ms, 3))} ms): vehicles fall back again and again"
        related = ("beacons.every", "beacons.period_ms", "channel.latency", "period_ms")
        yield Problem(key="control.beacon_age_limit_ms", text=text, related=related)


def _scope(
    scope: Rule | Outage | Scope, key: str, scenario: Scenario, sets: dict[str, frozenset[int]]
) -> Iterator[Problem]:
    """Note if a scope is after the run, covers no link, or no vehicle can be there."""
    end_s = scenario.cycles * scenario.period_ns / NS_PER_S
    if scope.from_s >= end_s:
        text = f"{trimmed(scope.from_s)} is not before the end of the run ({trimmed(end_s)} s)"
        yield Problem(key=f"{key}.from_s", text=text, related=("duration_s",))
        return
    source, destination = (
        members(text or "all", scenario.fleet.size, sets)
        for text in (scope.source, scope.destination)
    )
    if not source or not destination or (len(source) == 1 and source == destination):
        text = "covers no link: no vehicle in source sends to another one in destination"
        related = (f"{key}.source", f"{key}.destination")
        yield Problem(key=key, text=text, related=related)
    low_m = -math.inf if scope.from_m is None else scope.from_m
    high_m = math.inf if scope.to_m is None else scope.to_m
    first_m, last_m = _reach_m(scenario, min(end_s, scope.until_s or end_s))
    nowhere = max(low_m, first_m) > min(high_m, last_m)
    if scenario.ring_length_m and low_m > high_m:  # the stretch includes position 0
        nowhere = low_m >= last_m and high_m < first_m
    if nowhere:
        where = f"{trimmed(first_m)} m to {trimmed(round(last_m, 3))} m"
        text = f"no vehicle is ever on this stretch; vehicles are from {where} along the road"
        stretch = (f"{key}.from_m", f"{key}.to_m", "fleet.gap_m", "duration_s")
        yield Problem(key=key, text=text, related=stretch)


def _reach_m(scenario: Scenario, until_s: float) -> tuple[float, float]:
    """Return the positions that vehicles can reach, m; on an open road none passes the first."""
    if scenario.ring_length_m is not None:
        return 0.0, scenario.ring_length_m
    fleet, control = scenario.fleet, scenario.control
    speeds = [fleet.speeds_at_start_mps[0], control.desired_speed_mps]
    speeds += [group.desired_speed_mps or 0.0 for group in fleet.groups]
    speeds += [switch.desired_speed_mps or 0.0 for switch in control.schedule]
    speeds += [event.highest_mps for event in scenario.profiles if event.vehicle == 1]
    return 0.0, fleet.positions_at_start_m[0] + max(speeds) * until_s
