"""What the array engine does not run, by name."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from zenvoy.laws import builtin, law_of
from zenvoy.links.table import distributions
from zenvoy.scenarios import Latency, Scenario, parameters_of, roster
from zenvoy.vehicles.arrays.beaconing import RULES
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.arrays.trial import fault_on_arrays


def uncovered(scenario: Scenario) -> list[str]:
    """Return what of a scenario the array engine does not run: a line for each, with its key."""
    return [*_of_scenario(scenario), *_of_channel(scenario), *_of_laws(scenario)]


def _of_scenario(scenario: Scenario) -> Iterator[str]:
    if scenario.clock == "realtime":
        yield "clock: realtime"
    if scenario.beacons.rule not in RULES:
        yield f"beacons.rule: {scenario.beacons.rule}"


def _of_channel(scenario: Scenario) -> Iterator[str]:
    channel = scenario.channel
    if channel.medium.access != "none":
        yield f"channel.medium.access: {channel.medium.access}"
    if channel.relay_hops > 1:
        yield f"channel.relay_hops: {channel.relay_hops}"
    if channel.duplicate > 0.0:
        yield f"channel.duplicate: {channel.duplicate:g}"
    rules = [(f"channel.rules.{n}.loss", rule.loss) for n, rule in enumerate(channel.rules)]
    for key, loss in [("channel.loss", channel.loss), *rules]:
        if loss is not None and loss.path_loss is not None:
            yield f"{key}.path_loss"


def _of_laws(scenario: Scenario) -> Iterator[str]:
    phases = dict.fromkeys(
        (phase.model, phase.parameters) for one in roster(scenario) for phase in one.phases
    )
    predicts = any(law_of(model).needs.prediction for model, _ in phases)
    if predicts and scenario.estimator.kind != "kalman":
        yield f"estimator.kind: {scenario.estimator.kind}"
    if predicts and scenario.control.neighbour_state == "position" and _forgets(scenario):
        yield "control.neighbour_state: position, with latencies beyond what vehicles remember"
    for model, given in phases:
        law = law_of(model)
        if model not in builtin():
            parameters = parameters_of(scenario.control, law, given)
            fault = fault_on_arrays(law, parameters, scenario.stall_limit_s)
            if fault is not None:
                yield f"control.model: {model}: {fault}"


def _forgets(scenario: Scenario) -> bool:
    """Whether a beacon may be older than the own positions that it is compared with."""
    channel, timing = scenario.channel, Timing.of(scenario)
    latencies = [channel.latency, *(rule.latency for rule in channel.rules)]
    greatest_ns = max(
        _greatest_ns(latency, channel.radio.delay_ms)
        for latency in latencies
        if latency is not None
    )
    # The frame's own time on the air, and a cycle until it is delivered.
    return greatest_ns + 3 * timing.period_ns > timing.keep_ns


def _greatest_ns(latency: Latency, technology_ms: tuple[float, float]) -> float:
    last = np.array([1.0 - 2.0**-53])
    delays = distributions()[latency.distribution].quantile(latency, technology_ms)
    return float(delays(last)[0]) + latency.sender_offset.max_ms * 1e6
