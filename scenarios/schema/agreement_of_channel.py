"""Checks within the channel: values that are valid alone but not together."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from zenvoy.links.table import distributions, loss_models
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.technologies import technologies
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.channel import Channel, Latency, Loss, Scope
    from zenvoy.scenarios.schema.scenario import Scenario

_PARAMETERS: Final = ("mean_ms", "std_ms", "min_ms", "max_ms", "samples_ms")


def channel_that_disagrees(scenario: Scenario) -> Iterator[Problem]:
    """Yield every disagreement within the channel of `scenario`, without places."""
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
    """Check that the technology has carrier sense, and that congestion control can use it."""
    medium, radio = channel.medium, channel.radio
    key = "channel.medium.access"
    if medium.access == "csma" and not radio.csma:
        able = ", ".join(name for name, each in technologies().items() if each.csma)
        text = f"csma is not possible with {radio.name}; allowed: none, or csma with {able}, "
        text += "or with a technology that has csma: true"
        yield Problem(key=key, text=text, related=("channel.technology", "channel.csma"))
    if medium.congestion_control != "none" and medium.access == "none":
        text = f"{medium.congestion_control} needs csma as {key} (none)"
        yield Problem(key="channel.medium.congestion_control", text=text, related=(key,))


def _delay(channel: Channel) -> Iterator[Problem]:
    """Check that a delay given for the technology is used."""
    latencies = [channel.latency, *(rule.latency for rule in channel.rules)]
    kinds = [latency.distribution for latency in latencies if latency is not None]
    if channel.delay_ms is not None and "technology" not in kinds:
        chosen = "channel.latency.distribution"
        text = f"is given, but {chosen} is {kinds[0]}; allowed: null"
        yield Problem(key="channel.delay_ms", text=text, related=(chosen,))


def _loss(loss: Loss, section: str) -> Iterator[Problem]:
    """Yield the contradictions that each loss model finds in its value."""
    for key, model in loss_models().items():
        for found in model.disagreements(getattr(loss, key), f"{section}.{key}"):
            yield Problem(key=found.key, text=found.text, related=found.related)


def _latency(latency: Latency, section: str) -> Iterator[Problem]:
    """Check that the distribution has all parameters that it needs and none that it ignores."""
    kind, chosen = latency.distribution, f"{section}.distribution"
    needs, may = distributions()[kind].needs, distributions()[kind].may
    missing = [name for name in needs if getattr(latency, name) in (None, ())]
    for name in missing:
        text = f"missing; {chosen} is {kind}, which needs {' and '.join(needs)}"
        yield Problem(key=f"{section}.{name}", text=text, related=(chosen,))
    for name in _PARAMETERS:
        value = getattr(latency, name)
        if value not in (None, ()) and name not in (*needs, *may):
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
    """Check that min_ms, mean_ms and max_ms are in ascending order, as far as they are given."""
    distribution = distributions()[latency.distribution]
    given = {name: getattr(latency, name) for name in ("min_ms", "mean_ms", "max_ms")}
    known = [(name, value) for name, value in given.items() if value is not None]
    for (low_name, low), (high_name, high) in pairwise(known):
        above = distribution.above_min and high_name == "mean_ms"
        if high < low or (above and high == low):
            relation = "not greater than" if above else "less than"
            low_key = f"{section}.{low_name}"
            text = f"{trimmed(high)} is {relation} {low_key} ({trimmed(low)})"
            yield Problem(key=f"{section}.{high_name}", text=text, related=(low_key,))
    lowest = distribution.positive
    if lowest is not None and given[lowest] == 0:
        text = f"0 is not greater than 0, which {distribution.name} needs"
        yield Problem(key=f"{section}.{lowest}", text=text)


def _scope(scope: Scope, key: str, scenario: Scenario) -> Iterator[Problem]:
    """Check that times and positions are in order."""
    if scope.until_s is not None and scope.until_s <= scope.from_s:
        begin = trimmed(scope.from_s)
        text = f"{trimmed(scope.until_s)} is not later than {key}.from_s ({begin})"
        yield Problem(key=f"{key}.until_s", text=text, related=(f"{key}.from_s",))
    low, high = scope.from_m, scope.to_m
    if scenario.road.type == "open" and low is not None and high is not None and low > high:
        text = f"{trimmed(high)} is less than {key}.from_m ({trimmed(low)}) on the open road"
        yield Problem(key=f"{key}.to_m", text=text, related=(f"{key}.from_m", "road.type"))
