"""What others report of their motion reaches a law, on floats and on arrays alike."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.cab import Cab, beacon
from tests.conftest import zenvoy
from tests.fleet.test_arrays import first_difference, in_batch, of_seeds, on_bus
from tests.streamed_log import read_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.scenarios import Loaded, load

ENGINES = ("processes", "arrays")

LAW = """
from dataclasses import dataclass
from zenvoy.laws import Column, Law, Needs, Output, known, where

NAMES = ("v", "a", "distance", "age", "command", "steps")
COLUMNS = tuple(Column(f"{who}_{name}") for who in ("ahead", "leader") for name in NAMES)

@dataclass(frozen=True)
class Parameters:
    gain: float = 0.2

def follow(seen, own):
    heard = known(seen.predecessor.v)
    wanted = where(heard, seen.predecessor.v, seen.speed + seen.ahead.v)
    a = own.gain * (wanted - seen.speed) + 0.01 * (seen.ahead.p - seen.length_m - 30.0)
    logged = (*seen.predecessor, *seen.leader, seen.acceleration)
    return Output(a - 0.1 * seen.acceleration, logged=logged)

def law(leader=True, **needs):
    return Law(
        name="REPORTS",
        acceleration=follow,
        parameters=Parameters,
        needs=Needs(predecessor=True, leader=leader, **needs),
        columns=(*COLUMNS, Column("own_a", "m/s²")),
    )

WITH_COMMANDS = law(commands=True, tolerates_silence=True)
WITHOUT = law()
OF_ONE = law(leader=False)
"""

SCENARIO = """
duration_s: 6
fleet: {size: 5}
control: {model: "reports.py:WITH_COMMANDS"}
events: [{type: brake, vehicle: 1, at_s: 1, duration_s: 2, deceleration_mps2: 2}]
"""


def loaded(folder: Path, *changes: str) -> Loaded:
    (folder / "reports.py").write_text(LAW)
    (folder / "s.yaml").write_text(SCENARIO)
    return load(str(folder / "s.yaml"), changes)


@pytest.mark.parametrize(
    "changes",
    [
        ("channel.loss.p=0",),
        ("channel.loss.p=0.6", "control.beacon_age_limit_ms=250"),
        ("channel.loss.p=0.6", "control.model=reports.py:WITHOUT"),
        ("road.type=open", "channel.loss.p=0.3", "control.platoon.size=2"),
        ("beacons={rule: every-nth, every: 3}",),
        ("period_ms=20", "beacons={period_ms: 100}"),
        ("vehicle.max_deceleration_mps2=0.5", "sensors.error=0.3"),
    ],
)
def test_both_engines_log_the_same(tmp_path: Path, changes: tuple[str, ...]) -> None:
    scenario = loaded(tmp_path, *changes).scenario
    assert uncovered(scenario) == []
    batch = of_seeds(scenario, scenario.seed, 9)
    assert first_difference(in_batch(batch, 0), on_bus(scenario)) is None


@pytest.mark.parametrize("changes", [(), ("period_ms=50", "beacons.period_ms=150")])
def test_processes_log_the_same(tmp_path: Path, changes: tuple[str, ...]) -> None:
    loaded(tmp_path)
    given = [part for change in changes for part in ("--set", change)]
    for engine in ENGINES:
        outcome = zenvoy(tmp_path, "run", "s.yaml", "--engine", engine, "--out", engine, *given)
        assert outcome.code == 0, outcome
    prints = {read_log(tmp_path / one / "run.mcap").result["fingerprint"] for one in ENGINES}
    assert len(prints) == 1


def cab(folder: Path, model: str) -> Cab:
    """Return vehicle 3 of 5 on a ring of 187.5 m; vehicle 2 is ahead, and vehicle 1 leads."""
    return Cab(loaded(folder, f"control.model=reports.py:{model}").scenario)


def reporting(vehicle: int, cycle: int, command: float | None, position: float) -> pb.Beacon:
    sent = beacon(vehicle, cycle, speed=20.0 + vehicle, acceleration=0.5 * vehicle)
    sent.position = position
    if command is not None:
        sent.commanded_acceleration = command
    return sent


def test_reports_hold_distance_age_command_and_steps(tmp_path: Path) -> None:
    driven = cab(tmp_path, "WITH_COMMANDS")
    driven.sense()
    driven.receive([reporting(1, 0, -0.25, 1_075.5)])
    driven.sense(acceleration=0.125)
    logged = driven.receive([reporting(2, 1, 0.75, 1_037.0)]).logged
    ahead = (22.0, 1.0, 37.0, 0.0, 0.75, 1.0)
    leader = (21.0, 0.5, 75.5, 0.1, -0.25, 2.0)
    assert list(logged) == pytest.approx([*ahead, *leader, 0.125], rel=1e-15)


def test_a_report_without_its_command_is_missing(tmp_path: Path) -> None:
    driven = cab(tmp_path, "WITH_COMMANDS")
    driven.sense()
    logged = driven.receive([reporting(2, 0, None, 1_037.0), reporting(1, 0, 0.0, 1_075.0)]).logged
    assert all(math.isnan(value) for value in logged[:6])
    assert not any(math.isnan(value) for value in logged[6:])


def test_a_ring_length_lies_between_the_first_vehicle_and_the_last(tmp_path: Path) -> None:
    first = Cab(loaded(tmp_path, "control.model=reports.py:OF_ONE").scenario, 1)
    first.sense()
    logged = first.receive([reporting(5, 0, None, 850.5)]).logged
    assert logged[2] == 38.0
    assert math.isnan(logged[4])  # the law asks for no commands


def test_beacons_hold_the_newest_command_only_where_a_law_needs_it(tmp_path: Path) -> None:
    driven = cab(tmp_path, "WITH_COMMANDS")
    assert driven.sense().commanded_acceleration == 0.0
    decided = driven.receive().acceleration
    assert decided != 0.0
    assert driven.sense().commanded_acceleration == decided
    driven.receive()
    # A reading that no command explains, as of a driver's foot on the brake, counts instead.
    assert driven.sense(acceleration=-5.0).commanded_acceleration == -5.0
    assert not cab(tmp_path, "WITHOUT").sense().HasField("commanded_acceleration")


@pytest.mark.parametrize(("model", "falls_back"), [("WITH_COMMANDS", False), ("WITHOUT", True)])
def test_a_law_that_tolerates_silence_does_not_fall_back(
    tmp_path: Path, model: str, falls_back: bool
) -> None:
    driven = cab(tmp_path, model)
    driven.sense()
    assert (driven.receive().mode == pb.MODE_FALLBACK_FM) == falls_back
