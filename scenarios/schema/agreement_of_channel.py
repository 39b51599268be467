"""Checks within the channel: values that are fine alone and impossible together."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.technologies import technologies
from zenvoy.scenarios.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.channel import Channel, Latency, Loss, Scope
    from zenvoy.scenarios.schema.scenario import Scenario

# What a distribution of latency cannot do without, and what else it may use.
_NEEDS: Final[dict[str, tuple[str, ...]]] = {
    "technology": (),
    "fixed": ("mean_ms",),
    "uniform": ("min_ms", "max_ms"),
    "normal": ("mean_ms", "std_ms"),
    "gamma": ("mean_ms", "std_ms"),
    "pareto": ("min_ms", "mean_ms"),
    "samples": ("samples_ms",),
}
_MAY: Final = {"normal": ("min_ms", "max_ms"), "gamma": ("min_ms", "max_ms"), "pareto": ("max_ms",)}
_PARAMETERS: Final = ("mean_ms", "std_ms", "min_ms", "max_ms", "samples_ms")


def channel_that_disagrees(scenario: Scenario) -> Iterator[Problem]:
    """Every disagreement within the channel of `scenario`, without places."""
    channel = scenario.channel
    yield from _loss(channel.loss, "channel.loss")
    yield from _latency(channel.latency, "channel.latency")
    yield from _medium(channel)
    yield from _delay(channel)
    for index, rule in enumerate(channel.rules):
        key = f"channel.rules.{index}"
        yield from _scope(rule, key, scenario)
        if rule.loss is not None:
            yield from _loss(rule.loss, f"{key}.loss")
        if rule.latency is not None:
            yield from _latency(rule.latency, f"{key}.latency")
    for index, outage in enumerate(channel.outages):
        yield from _scope(outage, f"channel.outages.{index}", scenario)


def _medium(channel: Channel) -> Iterator[Problem]:
    """Carrier sense is 802.11's, and congestion control goes by what it senses."""
    medium, radio = channel.medium, channel.radio
    key = "channel.medium.access"
    if medium.access == "csma" and not radio.csma:
        able = ", ".join(name for name, each in technologies().items() if each.csma)
        text = f"csma is not for {radio.name}; allowed: none, or {able}, or one with csma: true"
        yield Problem(key=key, text=text, related=("channel.technology", "channel.csma"))
    if medium.congestion_control != "none" and medium.access == "none":
        text = f"{medium.congestion_control} needs csma as {key} (none)"
        yield Problem(key="channel.medium.congestion_control", text=text, related=(key,))


def _delay(channel: Channel) -> Iterator[Problem]:
    """A delay in place of the technology's is used."""
    latencies = [channel.latency, *(rule.latency for rule in channel.rules)]
    kinds = [latency.distribution for latency in latencies if latency is not None]
    if channel.delay_ms is not None and "technology" not in kinds:
        chosen = "channel.latency.distribution"
        text = f"is given, but {chosen} is {kinds[0]}; allowed: null"
        yield Problem(key="channel.delay_ms", text=text, related=(chosen,))


def _loss(loss: Loss, section: str) -> Iterator[Problem]:
    """What leaves a state of the loss model cannot be more than certain; distances rise."""
    states = loss.four_state
    leaving = {"p14": (states.p14, "p13", states.p13), "p32": (states.p32, "p31", states.p31 or 0)}
    for name, (value, other, beside) in leaving.items():
        if value + beside > 1:
            key = f"{section}.four_state.{other}"
            text = f"{trimmed(value)} and {key} ({trimmed(beside)}) are more than 1 together"
            yield Problem(key=f"{section}.four_state.{name}", text=text, related=(key,))
    for index, ((before, _), (distance, _)) in enumerate(pairwise(loss.by_distance), start=1):
        if distance <= before:
            text = (
                f"{trimmed(distance)} is not greater than the distance before ({trimmed(before)})"
            )
            yield Problem(key=f"{section}.by_distance.{index}.0", text=text)


def _latency(latency: Latency, section: str) -> Iterator[Problem]:
    """Each distribution has its parameters, all that it needs and none that it ignores."""
    kind, chosen = latency.distribution, f"{section}.distribution"
    needs = _NEEDS[kind]
    missing = [name for name in needs if getattr(latency, name) in (None, ())]
    for name in missing:
        text = f"missing; {chosen} is {kind}, which needs {' and '.join(needs)}"
        yield Problem(key=f"{section}.{name}", text=text, related=(chosen,))
    for name in _PARAMETERS:
        value = getattr(latency, name)
        if value not in (None, ()) and name not in (*needs, *_MAY.get(kind, ())):
            nothing = "[]" if name == "samples_ms" else "null"
            text = f"is given, but {chosen} is {kind}; allowed: {nothing}"
            yield Problem(key=f"{section}.{name}", text=text, related=(chosen,))
    if not missing:
        yield from _in_order(latency, section)
    offset = latency.sender_offset
    if offset.from_messages > offset.to_messages:
        key = f"{section}.sender_offset.from_messages"
        text = f"{offset.to_messages} is less than {key} ({offset.from_messages})"
        yield Problem(key=f"{section}.sender_offset.to_messages", text=text, related=(key,))


def _in_order(latency: Latency, section: str) -> Iterator[Problem]:
    """min_ms, mean_ms and max_ms rise, as far as they are given."""
    spreads = latency.distribution in ("gamma", "pareto")  # from min_ms on, so the mean is above
    given = {name: getattr(latency, name) for name in ("min_ms", "mean_ms", "max_ms")}
    known = [(name, value) for name, value in given.items() if value is not None]
    for (low_name, low), (high_name, high) in pairwise(known):
        above = spreads and high_name == "mean_ms"
        if high < low or (above and high == low):
            relation = "not greater than" if above else "less than"
            low_key = f"{section}.{low_name}"
            text = f"{trimmed(high)} is {relation} {low_key} ({trimmed(low)})"
            yield Problem(key=f"{section}.{high_name}", text=text, related=(low_key,))
    lowest = {"pareto": "min_ms", "gamma": "mean_ms"}.get(latency.distribution)
    if lowest is not None and given[lowest] == 0:
        text = f"0 is not greater than 0, which {latency.distribution} needs"
        yield Problem(key=f"{section}.{lowest}", text=text)


def _scope(scope: Scope, key: str, scenario: Scenario) -> Iterator[Problem]:
    """Times and places rise."""
    if scope.until_s is not None and scope.until_s <= scope.from_s:
        begin = trimmed(scope.from_s)
        text = f"{trimmed(scope.until_s)} is not later than {key}.from_s ({begin})"
        yield Problem(key=f"{key}.until_s", text=text, related=(f"{key}.from_s",))
    low, high = scope.from_m, scope.to_m
    if scenario.road.type == "open" and low is not None and high is not None and low > high:
        text = f"{trimmed(high)} is less than {key}.from_m ({trimmed(low)}) on the open road"
        yield Problem(key=f"{key}.to_m", text=text, related=(f"{key}.from_m", "road.type"))
