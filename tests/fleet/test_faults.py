"""Runs with faults are repeatable, on every bus, and their logs say when faults were in force."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import run
from tests.faults import scenario_with
from zenvoy.analysis.log.load import load
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.topics import EVENTS, FLEET_COMMAND, Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.scenarios import Scenario

MANY: Final = """
duration_s: 6
fleet: {size: 8, groups: [{name: drawn, share: 0.4}]}
control: {model: PBCM, v2v_wait_ms: 50, system_delay_ms: 70}
vehicle: {actuator_lag_s: 0.2}
channel: {loss: {p: 0.1}}
faults:
  - {type: sensor-biased, vehicles: drawn, at_s: 1, duration_s: 2, gap_m: 4, speed_mps: -1}
  - {type: sensor-drifting, vehicles: 2-3, at_s: 1, duration_s: 3, gap_mps: -1}
  - {type: sensor-jumping, vehicles: 4, at_s: 1, share: 30%, relative_speed_mps: 2}
  - {type: sensor-frozen, vehicles: 5, at_s: 2, duration_s: 1, sensor: all}
  - {type: sensor-blind, vehicles: 6, at_s: 2, duration_s: 1}
  - {type: transmitter-silent, vehicles: 1, at_s: 1.5, duration_s: 2}
  - {type: transmitter-repeating, vehicles: 2, at_s: 2, duration_s: 2, new_times: true}
  - {type: transmitter-lying, vehicles: 3, at_s: 3, acceleration_mps2: 1, gap_m: 5}
  - {type: actuator-stuck, vehicles: 8, at_s: 2.03, duration_s: 1.5}
"""


def test_processes_log_the_same_as_one_process(tmp_path: Path) -> None:
    ways = {
        "alone": (),
        "shared": ("--vehicles-per-process", "3"),
        "in one": ("--engine", "in-process"),
    }
    logs = {name: run(tmp_path / name, MANY, *options) for name, options in ways.items()}
    assert len({log.result["fingerprint"] for log in logs.values()}) == 1
    without = MANY[: MANY.index("faults:")]
    plain = run(tmp_path / "without", without, "--engine", "in-process")
    assert plain.result["fingerprint"] != logs["alone"].result["fingerprint"]


def test_the_log_has_begin_and_end_of_each_fault_by_vehicle(tmp_path: Path) -> None:
    text = """
duration_s: 3
fleet: {size: 4}
faults:
  - {type: transmitter-silent, vehicles: 2-3, at_s: 1.05, duration_s: 1}
  - {type: sensor-biased, vehicles: 4, at_s: 2, gap_m: 5}
"""
    run(tmp_path / "r", text, "--engine", "in-process")
    found = load(tmp_path / "r" / "out" / "run.mcap").events
    begin, end = pb.EVENT_FAULT, pb.EVENT_FAULT_END
    logged = [(e.time_ns / 1e9, e.kind, e.vehicle, e.text) for e in found if e.kind in {begin, end}]
    assert logged == [
        (1.05, begin, 2, "transmitter silent"),
        (1.05, begin, 3, "transmitter silent"),
        (2.0, begin, 4, "sensor biased: gap +5 m"),
        (2.05, end, 2, "transmitter silent"),
        (2.05, end, 3, "transmitter silent"),
    ]


def messages(scenario: Scenario) -> list[tuple[Topic[Any], int, bytes]]:
    """Return what the log of a run has, but events."""
    log: list[tuple[Topic[Any], int, bytes]] = []

    def keep(topic: Topic[Any], time_ns: int, payload: bytes) -> None:
        if topic is not EVENTS:
            log.append((topic, time_ns, payload))

    InProcessBus(agents_of(scenario), keep).run()
    return log


SHORT: Final = {"duration_s": 1.0, "control": {"model": "PBCM"}, "sensors": {"error": 0.1}}
FAULTS: Final = st.sampled_from(
    [
        {"type": "sensor-biased", "gap_m": 5.0},
        {"type": "sensor-jumping", "gap_m": 5.0, "share": 1.0},
        {"type": "sensor-blind"},
        {"type": "transmitter-silent"},
        {"type": "transmitter-lying", "gap_m": 5.0},
        {"type": "actuator-stuck", "acceleration_mps2": 1.0},
    ]
)


@settings(max_examples=12)
@given(fault=FAULTS, vehicle=st.integers(1, 4), cycle=st.integers(1, 12))
def test_a_fault_changes_nothing_before_it_begins(
    fault: dict[str, Any], vehicle: int, cycle: int
) -> None:
    """Those that begin after the end change nothing at all."""
    plain = messages(scenario_with([], size=4, **SHORT))
    fault = {**fault, "vehicles": vehicle, "at_s": cycle / 10}
    faulty = messages(scenario_with([fault], size=4, **SHORT))
    at_ns = cycle * 100_000_000
    assert [m for m in faulty if m[1] < at_ns] == [m for m in plain if m[1] < at_ns]
    assert (faulty == plain) == (cycle >= 10)


def test_arrays_refuse_faults_by_name() -> None:
    fault = {"type": "transmitter-silent", "vehicles": 1, "at_s": 0}
    assert uncovered(scenario_with([fault])) == [
        "faults: transmitter-silent does not run on arrays; allowed: []"
    ]


@pytest.mark.parametrize("model", ["FM", "BCM", "MBCM", "PBCM", "SPBCM", "CACC", "IDM"])
def test_every_law_survives_every_fault(model: str) -> None:
    """A run ends in order, with finite commands, whatever breaks."""
    kinds: list[dict[str, Any]] = [
        {"type": "sensor-blind"},
        {"type": "sensor-frozen", "sensor": "all"},
        {"type": "sensor-biased", "gap_m": -40.0, "speed_mps": -50.0},
        {"type": "transmitter-repeating", "new_times": True},
        {"type": "transmitter-lying", "position_m": 1e6, "speed_mps": -1e3, "gap_m": -1e3},
        {"type": "actuator-stuck", "acceleration_mps2": -5.0},
    ]
    faults = [{**kind, "vehicles": n + 2, "at_s": 0.5} for n, kind in enumerate(kinds)]
    scenario = scenario_with(faults, size=8, duration_s=4.0, control={"model": model})
    log = messages(scenario)
    rows = [pb.FleetCommand.FromString(d) for topic, _, d in log if topic is FLEET_COMMAND]
    assert len(rows) == 40
    assert all(abs(a) <= 3.0 for row in rows for a in row.acceleration)
