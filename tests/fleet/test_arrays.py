"""The array engine writes the log of the in-process bus for each seed, message by message.

`ARRAY_EXAMPLES=2000 pytest tests/fleet/test_arrays.py` tries 2000 whole scenarios.
"""

from __future__ import annotations

import os
from typing import Any, Final, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fleet.whole_scenarios import whole_scenarios
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.topics import Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.fleet.arrays.batch import Batch
from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.fleet.arrays.log import RunLog
from zenvoy.scenarios import Scenario, load

EXAMPLES: Final = int(os.environ.get("ARRAY_EXAMPLES", "40"))


class Message(NamedTuple):
    """A logged message."""

    topic: str
    time_ns: int
    payload: bytes


class Recorded(list[Message]):
    """A list that stands in for a recorder."""

    def log(self, topic: Topic[Any], time_ns: int, payload: bytes) -> None:
        self.append(Message(topic.log_name, time_ns, payload))


def on_bus(scenario: Scenario) -> list[Message]:
    """Return the messages that the in-process bus logs."""
    found = Recorded()
    InProcessBus(agents_of(scenario), found.log).run()
    return found


def in_batch(scenarios: list[Scenario], run: int) -> list[Message]:
    """Return the messages that one run of a batch logs."""
    batch, found = Batch(scenarios, whole=True), Recorded()
    log = RunLog(batch, run, found.log)
    for cycle in batch.cycles():
        log.take(cycle)
    return found


def of_seeds(scenario: Scenario, *seeds: int) -> list[Scenario]:
    """Return the scenario with each of these seeds."""
    values = scenario.model_dump(mode="json")
    return [Scenario.model_validate({**values, "seed": seed}) for seed in seeds]


def first_difference(found: list[Message], expected: list[Message]) -> str | None:
    """Return where two logs differ, or None if they are equal."""
    for number, (one, other) in enumerate(zip(found, expected, strict=False)):
        if one != other:
            return f"message {number}: {one.topic} of {one.time_ns}, {other.topic}"
    return None if len(found) == len(expected) else f"{len(found)} messages, {len(expected)}"


BUILT_IN: Final = {
    "case 01": ("paper/case-01", ()),
    "case 10": ("paper/case-10", ()),
    "case 16": ("paper/case-16", ()),
    "heavy-loss": ("heavy-loss", ()),
    "lead": ("lead/us06", ()),
    "manoeuvre": ("manoeuvres/open-gap", ()),
    "half-converted": ("mixed/half-converted", ()),
    "humans": ("mixed/humans", ()),
    "platoons": ("mixed/platoons", ()),
    "time headway": ("following/acc", ()),
    "drivers": ("following/idm", ()),
    "a car that stops waves": (
        "ring/follower-stopper",
        ("control.schedule.0.at_s=4", "control.schedule.1.at_s=12"),
    ),
    "a car that leads": ("mixed/lcc", ()),
    "predictor feedback": ("following/pf-cacc", ()),
    "a car that remembers": ("ring/pi", ("control.schedule.0.at_s=4",)),
    "feedforward": ("plexe/ploeg", ()),
    "commands in a platoon": ("plexe/cacc", ()),
    "consensus": ("plexe/consensus", ()),
    "tow truck": ("plexe/gsbl", ()),
    "silence": ("plexe/dcacc", ("channel.outages.0.from_s=5", "channel.outages.0.until_s=15")),
    "probe": ("probes/pbcm", ()),
    "bursts": ("beyond/case-15-bursts", ("control.schedule.0.at_s=2",)),
    "bursts and two cycles of delay": ("beyond/case-16-bursts", ("control.schedule.0.at_s=2",)),
    "silence for longer than all patience": (
        "quickstart",
        ("control.model=SPBCM", "control.parameters.patience_s=2", "channel.loss.p=0.97"),
    ),
    "unicast": ("technologies/5g-mmwave", ()),
    "stopped by a collision": ("paper/case-01", ("on_collision=stop", "control.gains.k_d=3")),
    "latency without bounds": (
        "paper/case-15",
        ("channel.latency={distribution: pareto, min_ms: 5, mean_ms: 12}",),
    ),
    "old beacons": ("paper/case-15", ("channel.loss.p=0.9",)),
    "beacons that are rarer than their age limit": (
        "paper/case-15",
        (
            "control.schedule.0.at_s=2",
            "control.neighbour_state=position",
            "control.v2v_wait_ms=0",
            "control.beacon_age_limit_ms=150",
            "beacons.period_ms=200",
        ),
    ),
    "commands that matter in some of the runs only": (
        "quickstart",
        (
            "road.type=open",
            "fleet.size=2",
            "control.model=FM",
            "fleet.groups=[{name: last, vehicles: 2, model: Ploeg}, "
            "{name: drawn, share: 0.5, model: FM}]",
            "events=[{type: brake, vehicle: 1, at_s: 2, duration_s: 1, deceleration_mps2: 3}]",
            "seed=2",
        ),
    ),
}


@pytest.mark.parametrize(("name", "changes"), BUILT_IN.values(), ids=BUILT_IN)
def test_built_in_scenarios_log_the_same(name: str, changes: tuple[str, ...]) -> None:
    scenario = load(name, changes, duration_s=20.0).scenario
    batch = of_seeds(scenario, 8, scenario.seed, 5)
    assert uncovered(scenario) == []
    assert first_difference(in_batch(batch, 1), on_bus(scenario)) is None


@given(whole_scenarios(), st.integers(0, 2**63 - 1))
@settings(max_examples=EXAMPLES)
def test_any_scenario_logs_the_same(scenario: Scenario, other_seed: int) -> None:
    batch = of_seeds(scenario, other_seed, scenario.seed)
    if uncovered(scenario):
        return
    assert first_difference(in_batch(batch, 1), on_bus(scenario)) is None
