"""What the array engine does not run, by name."""

from __future__ import annotations

import math
from collections.abc import Iterator

from zenvoy.laws import builtin, law_of
from zenvoy.laws.estimator import KALMAN
from zenvoy.links.distribution import greatest_ns
from zenvoy.links.table import distributions
from zenvoy.scenarios import Latency, Scenario, key_of, name_of, parameters_of, roster
from zenvoy.vehicles.arrays.beaconing import RULES
from zenvoy.vehicles.arrays.refusal import NotCoveredError
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.arrays.trial import fault_on_arrays

__all__ = ["NotCoveredError", "uncovered"]


def uncovered(scenario: Scenario) -> list[str]:
    """Return a line for each setting of a scenario that the array engine does not run.

    A line has the key, the value, and what is allowed.
    """
    return [*_of_scenario(scenario), *_of_channel(scenario), *_of_control(scenario)]


def _line(key: str, value: object, allowed: str) -> str:
    return f"{key}: {value} does not run on arrays; allowed: {allowed}"


def _of_scenario(scenario: Scenario) -> Iterator[str]:
    if scenario.clock == "realtime":
        yield _line("clock", "realtime", "lock-step")
    if scenario.faults:
        kinds = ", ".join(dict.fromkeys(fault.type for fault in scenario.faults))
        yield _line("faults", kinds, "[]")
    if scenario.beacons.rule not in RULES:
        yield _line("beacons.rule", scenario.beacons.rule, ", ".join(RULES))


def _of_channel(scenario: Scenario) -> Iterator[str]:
    channel = scenario.channel
    if channel.medium.access != "none":
        yield _line("channel.medium.access", channel.medium.access, "none")
    if channel.relay_hops > 1:
        yield _line("channel.relay_hops", channel.relay_hops, "1")
    if channel.duplicate > 0.0:
        yield _line("channel.duplicate", f"{channel.duplicate:g}", "0")
    rules = [(f"channel.rules.{n}.loss", rule.loss) for n, rule in enumerate(channel.rules)]
    for key, loss in [("channel.loss", channel.loss), *rules]:
        if loss is not None and loss.path_loss is not None:
            yield _line(f"{key}.path_loss", "received power", "null")


def _of_control(scenario: Scenario) -> Iterator[str]:
    phases = dict.fromkeys(
        (phase.model, phase.parameters) for one in roster(scenario) for phase in one.phases
    )
    predicts = any(law_of(model).needs.prediction for model, _ in phases)
    if predicts and scenario.estimator.kind != KALMAN:
        yield _line("estimator.kind", name_of(scenario.estimator.kind), KALMAN)
    lags_s = {one.lag_s for one in roster(scenario)}
    if lags_s != {0.0} and any(law_of(model).needs.shares_links for model, _ in phases):
        what = f"{max(lags_s):g} with a law that shares links"
        yield _line("vehicle.actuator_lag_s", what, "null")
    if predicts and scenario.control.neighbour_state == "position":
        yield from _of_memory(scenario)
    for model, given in phases:
        law = law_of(model)
        if model not in builtin():
            parameters = parameters_of(scenario.control, law, given)
            fault = fault_on_arrays(law, parameters, scenario.stall_limit_s)
            if fault is not None:
                yield (
                    f"{key_of(scenario, model)}: {name_of(model)} does not run on arrays: {fault};"
                    " allowed: a law for floats and arrays (docs/arrays.md)"
                )


def _of_memory(scenario: Scenario) -> Iterator[str]:
    """Yield a line for each latency for which vehicles forget their own positions too early."""
    channel, timing = scenario.channel, Timing.of(scenario)
    # A delivery takes up to a cycle, and the frame's time on the air up to two.
    limit_ns = timing.keep_ns - 3 * timing.period_ns
    latencies = [("channel.latency", channel.latency)]
    latencies += [
        (f"channel.rules.{n}.latency", rule.latency)
        for n, rule in enumerate(channel.rules)
        if rule.latency is not None
    ]
    for key, latency in latencies:
        greatest_ns = _greatest_ns(latency, channel.radio.delay_ms)
        if greatest_ns > limit_ns:
            what = f"{latency.distribution} of up to {greatest_ns * 1e-6:g} ms"
            allowed = f"up to {limit_ns * 1e-6:g} ms with control.neighbour_state: position"
            yield _line(key, what, allowed)


def _greatest_ns(latency: Latency, technology_ms: tuple[float, float]) -> float:
    delays = distributions()[latency.distribution].quantile(latency, technology_ms)
    greatest = greatest_ns(delays)
    return math.inf if greatest is None else greatest + latency.sender_offset.max_ms * 1e6
