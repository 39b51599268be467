"""The array engine writes the log of the in-process bus for each seed, message by message.

`ARRAY_EXAMPLES=2000 pytest tests/fleet/test_arrays.py` tries 2000 whole scenarios.
"""

from __future__ import annotations

import json
import os
from typing import Any, Final, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.topics import Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.fleet.arrays.batch import Batch
from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.fleet.arrays.log import RunLog
from zenvoy.laws import builtin
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


def fraction(most: float = 1.0) -> st.SearchStrategy[float]:
    return st.floats(0.0, most, allow_subnormal=False)


LAWS: Final = st.sampled_from(list(builtin()))
LOSS: Final = st.fixed_dictionaries(
    {"p": fraction()},
    optional={
        "corrupt": fraction(),
        "by_distance": st.just([[0, 0.1], [80, 0.8]]),
        "gilbert_elliott": st.fixed_dictionaries({"p": fraction(), "r": fraction()}),
        "four_state": st.fixed_dictionaries({"p13": fraction(0.5), "p32": fraction(0.5)}),
    },
)
LATENCY: Final = st.one_of(
    st.just({"distribution": "technology"}),
    st.builds(lambda ms: {"distribution": "fixed", "mean_ms": ms}, st.floats(0, 500)),
    st.builds(
        lambda low, span, order: {
            "distribution": "uniform",
            "min_ms": low,
            "max_ms": low + span,
            "reorder": order,
        },
        st.floats(0, 200),
        st.floats(1, 300),
        st.booleans(),
    ),
    st.just({"distribution": "gamma", "mean_ms": 60, "std_ms": 40, "max_ms": 400}),
    st.just(
        {"distribution": "samples", "samples_ms": [5, 20, 150], "sender_offset": {"max_ms": 90}}
    ),
)
VEHICLE: Final = st.fixed_dictionaries(
    {"actuator_lag_s": st.sampled_from([None, 0.001, 0.1, 0.5, 3.0])},
    optional={
        "max_acceleration_mps2": st.floats(0.5, 5.0),
        "max_deceleration_mps2": st.floats(0.5, 9.0),
    },
)


@st.composite
def whole_scenarios(draw: st.DrawFn) -> Scenario:
    """Draw fleets of 2 to 12, for some seconds, with all that the array engine runs."""
    size = draw(st.integers(2, 12))
    ring = draw(st.booleans())
    several = st.lists(
        st.builds(lambda a, b: f"{min(a, b)}-{max(a, b)}", *[st.integers(1, size)] * 2), max_size=2
    )
    groups = [
        {
            "name": f"g{number}",
            "vehicles": members,
            "vehicle": draw(VEHICLE),
            "model": draw(LAWS),
            "beacons": draw(st.booleans()),
        }
        for number, members in enumerate(draw(several))
    ]
    if draw(st.booleans()):
        some = {"name": "some", "share": draw(fraction()), "model": draw(LAWS)}
        groups.append({**some, "vehicle": draw(VEHICLE)})
    schedule = [
        {"at_s": draw(st.floats(0.1, 3.0)), "model": draw(LAWS)},
        {"at_s": 3.0, "desired_speed_mps": 25.0, "ramp_s": draw(st.sampled_from([0.0, 1.5]))},
    ]
    events: list[dict[str, Any]] = []
    if draw(st.booleans()):
        who = draw(st.integers(1, size))
        brake = {
            "type": "brake",
            "vehicle": who,
            "at_s": 1.0,
            "duration_s": draw(st.floats(0.1, 3)),
        }
        events.append({**brake, "deceleration_mps2": draw(st.floats(0.5, 9.0))})
    if draw(st.booleans()):
        sine = {"type": "sine", "vehicle": 1, "at_s": 0.5, "duration_s": 2.0, "mean_mps": 20.0}
        events.append({**sine, "amplitude_mps": 3.0, "frequency_hz": 0.5})
    rules = draw(st.lists(st.fixed_dictionaries({"loss": LOSS, "latency": LATENCY}), max_size=1))
    outages = [{"from_s": 1.0, "until_s": 2.5, "source": "1-2"}] if draw(st.booleans()) else []
    period_ms = draw(st.sampled_from([100.0, 100.0, 50.0]))
    wait_ms = draw(st.sampled_from([0.0, 10.4, 11.0, 0.5 * period_ms, period_ms - 1.0]))
    values = {
        "duration_s": draw(st.floats(1.0, 6.0)),
        "period_ms": period_ms,
        "seed": draw(st.integers(0, 2**63 - 1)),
        "on_collision": draw(st.sampled_from(["continue", "stop"])),
        "road": {"type": "ring" if ring else "open"},
        "fleet": {
            "size": size,
            "gap_m": draw(st.floats(5.5, 60.0)),
            "speed_mps": draw(st.floats(0.0, 35.0)),
            "groups": groups,
        },
        "vehicle": draw(VEHICLE),
        "control": {
            "model": draw(LAWS),
            "schedule": schedule,
            "multi_node": {"neighbours": draw(st.integers(1, 3))},
            "platoon": {"size": draw(st.sampled_from([None, 2]))},
            "neighbour_state": draw(st.sampled_from(["radar", "position"])),
            "v2v_wait_ms": wait_ms,
            "system_delay_ms": draw(st.one_of(st.just(89.0), st.floats(0.0, 350.0))),
            "beacon_age_limit_ms": draw(st.sampled_from([150.0, 1000.0, 1e6])),
        },
        "beacons": draw(
            st.sampled_from(
                [
                    {"rule": "every-cycle"},
                    {"rule": "every-nth", "every": 3},
                    {"period_ms": 200.0},
                    {"period_ms": 300.0, "staggered": True},
                ]
            )
        ),
        "sensors": {
            "error": draw(st.sampled_from([0.0, 0.03, 0.1])),
            "distribution": draw(st.sampled_from(["uniform", "gaussian"])),
            "position_std_m": draw(st.sampled_from([0.0, 1.0])),
        },
        "channel": {
            "range_m": draw(st.sampled_from([40.0, 100.0, 1000.0])),
            "broadcast": draw(st.booleans()),
            "loss": draw(LOSS),
            "latency": draw(LATENCY),
            "rules": rules,
            "outages": outages,
        },
        "events": events,
    }
    return _valid(values)


def _valid(values: dict[str, Any]) -> Scenario:
    """Return the scenario, or a plainer one if its drawn values exclude each other."""
    if "SPBCM" in json.dumps(values):
        values = {**values, "control": {**values["control"], "neighbour_state": "radar"}}
    try:
        return Scenario.model_validate(values)
    except ValueError:
        plain = {**values, "control": {**values["control"], "model": "FM", "schedule": []}}
        plain["fleet"] = {**values["fleet"], "groups": []}
        return Scenario.model_validate({**plain, "events": []})


@given(whole_scenarios(), st.integers(0, 2**63 - 1))
@settings(max_examples=EXAMPLES)
def test_any_scenario_logs_the_same(scenario: Scenario, other_seed: int) -> None:
    batch = of_seeds(scenario, other_seed, scenario.seed)
    if uncovered(scenario):
        return
    assert first_difference(in_batch(batch, 1), on_bus(scenario)) is None
