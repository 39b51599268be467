"""Desired gaps, speeds and gains change on schedule."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import zenvoy
from tests.scenarios.motions import S_NS, motion, scenario_of
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import ScenarioError, load, roster
from zenvoy.scenarios.schema.courses import course as course_of

# Courses ------------------------------------------------------------------------------------


def test_a_value_changes_as_a_step_or_a_ramp() -> None:
    course = course_of(10.0, [(5 * S_NS, 0, 20.0), (10 * S_NS, 4 * S_NS, 12.0)])
    times = [0, 5 * S_NS - 1, 5 * S_NS, 10 * S_NS, 11 * S_NS, 14 * S_NS, 99 * S_NS]
    assert [course.at(t) for t in times] == [10.0, 10.0, 20.0, 20.0, 18.0, 12.0, 12.0]
    assert [course.rate(t) for t in times] == [0.0, 0.0, 0.0, -2.0, -2.0, 0.0, 0.0]
    assert course.is_constant(0, 5 * S_NS - 1)
    assert not course.is_constant(0, 5 * S_NS)
    assert not course.is_constant(9 * S_NS, 11 * S_NS)
    assert course.is_constant(14 * S_NS, 99 * S_NS)
    # a step there and back within the span
    there_and_back = course_of(1.0, [(S_NS, 0, 2.0), (2 * S_NS, 0, 1.0)])
    assert not there_and_back.is_constant(0, 9 * S_NS)


def test_a_new_change_starts_from_the_value_that_a_ramp_has_reached() -> None:
    course = course_of(0.0, [(0, 10 * S_NS, 10.0), (5 * S_NS, 5 * S_NS, 0.0)])
    assert [course.at(t * S_NS) for t in (0, 2, 5, 6, 10, 11)] == [0.0, 2.0, 5.0, 4.0, 0.0, 0.0]


changes = st.lists(
    st.tuples(st.integers(0, 30), st.integers(0, 20), st.floats(0.0, 100.0)), max_size=6
).map(sorted)


@given(changes, st.lists(st.integers(0, 60_000), min_size=1, max_size=20))
def test_a_course_has_only_the_jumps_of_its_steps(
    entries: list[tuple[int, int, float]], times_ms: list[int]
) -> None:
    course = course_of(50.0, [(at * S_NS, ramp * S_NS, value) for at, ramp, value in entries])
    instants = [time_ns for time_ns, _ in course.points]
    assert instants == sorted(instants)
    assert course.points[0][0] == 0
    assert course.at(200 * S_NS) == (entries[-1][2] if entries else 50.0)
    values = [50.0, *(value for _, _, value in entries)]
    for time_ms in times_ms:
        value, rate = course.at(time_ms * 1_000_000), course.rate(time_ms * 1_000_000)
        assert min(values) - 1e-9 <= value <= max(values) + 1e-9
        if all(time_ms * 1_000_000 != at for at in instants):
            assert course.at(time_ms * 1_000_000 + 1_000) == pytest.approx(
                value + rate * 1e-6, abs=1e-6
            )


# Targets of vehicles --------------------------------------------------------------------------

MIXED = """
duration_s: 6
road: {type: open}
fleet:
  size: 6
  gap_m: 30
  groups:
    - {name: wide, vehicles: 5-6, desired_gap_m: 50}
    - {name: stiff, vehicles: 3, gains: {k_d: 0.3}, model: BCM}
control:
  model: CACC
  desired_gap_m: 30
  schedule:
    - {at_s: 1, desired_gap_m: 35, ramp_s: 2}
    - {at_s: 2, gains: {k_v: 0.9}}
    - {at_s: 3, vehicles: not wide, model: PBCM, desired_speed_mps: 28, ramp_s: 1}
    - {at_s: 4, vehicles: wide, desired_gap_m: 40, gains: {k_d: 0.2, k_c: 0}}
"""


def test_the_schedule_spares_values_of_groups_that_it_does_not_name(tmp_path: Path) -> None:
    vehicles = roster(scenario_of(tmp_path, MIXED))
    assert [s.targets.desired_gap_m.at(2 * S_NS) for s in vehicles] == [32.5] * 4 + [50.0] * 2
    assert [s.targets.desired_gap_m.at(5 * S_NS) for s in vehicles] == [35.0] * 4 + [40.0] * 2
    assert [s.targets.k_v.at(5 * S_NS) for s in vehicles] == [0.9, 0.9, 0.5, 0.9, 0.9, 0.9]
    assert [s.targets.k_d.at(5 * S_NS) for s in vehicles] == [0.1, 0.1, 0.3, 0.1, 0.2, 0.2]
    assert [s.targets.k_c.at(5 * S_NS) for s in vehicles] == [0.05] * 4 + [0.0] * 2
    assert [s.targets.desired_speed_mps.at(round(3.5 * S_NS)) for s in vehicles] == [29.0] * 4 + [
        30
    ] * 2
    assert [s.targets.cruises_ns for s in vehicles] == [3 * S_NS] * 4 + [None] * 2
    assert vehicles[0].program == ((0, "CACC"), (3 * S_NS, "PBCM"))
    assert vehicles[5].program == ((0, "CACC"),)


def test_a_schedule_of_models_alone_changes_no_target() -> None:
    assert not any(own.targets.change for own in roster(load("paper/case-15").scenario))


@pytest.mark.parametrize(
    ("entry", "lines"),
    [
        (
            "{at_s: 1}",
            [
                "control.schedule.0: changes nothing; allowed: model, desired_gap_m, "
                "desired_speed_mps or gains"
            ],
        ),
        (
            "{at_s: 1, gains: {}}",
            [
                "control.schedule.0: changes nothing; allowed: model, desired_gap_m, "
                "desired_speed_mps or gains"
            ],
        ),
        (
            "{at_s: 1, model: FM, ramp_s: 3}",
            ["control.schedule.0.ramp_s: 3 is given, but a model changes at once; allowed: 0"],
        ),
        (
            "{at_s: 1, desired_gap_m: 5}",
            [
                "control.schedule.0.desired_gap_m: 5 is not greater than fleet.length_m (5)",
            ],
        ),
        (
            "{at_s: 1, desired_gap_m: 20, ramp_s: -1}",
            ["control.schedule.0.ramp_s: -1 is not in [0, 1e9]"],
        ),
        (
            "{at_s: 1, gains: {k_x: 1}}",
            [
                "control.schedule.0.gains.k_x: unknown key; did you mean 'k_v'? "
                "allowed: k_d, k_v, k_c",
                "control.schedule.0: changes nothing; allowed: model, desired_gap_m, "
                "desired_speed_mps or gains",
            ],
        ),
    ],
)
def test_wrong_entries_are_refused(tmp_path: Path, entry: str, lines: list[str]) -> None:
    with pytest.raises(ScenarioError) as caught:
        scenario_of(tmp_path, f"control:\n  schedule:\n    - {entry}\n")
    place = f"  ({tmp_path / 's.yaml'}, line 3)"
    assert str(caught.value).splitlines() == [line + place for line in lines]


# Runs -----------------------------------------------------------------------------------------


def test_processes_change_their_targets_with_the_same_bits(tmp_path: Path) -> None:
    """The scenario has all models, ramps, and changes during ramps, on both buses."""
    brake = "events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2, return_s: 2}]\n"
    (tmp_path / "s.yaml").write_text(MIXED + brake)
    prints = set()
    for bus in ("in-process", "zenoh"):
        assert zenvoy(tmp_path, "run", "s.yaml", "--bus", bus, "--out", bus).code == 0
        info = zenvoy(tmp_path, "info", f"{bus}/run.mcap").out
        prints |= {line.strip() for line in info.splitlines() if "fingerprint" in line}
    assert len(prints) == 1, prints


def test_a_platoon_opens_a_gap() -> None:
    scenario = load("manoeuvres/open-gap", ["sensors.error=0"], duration_s=90.0).scenario
    position, speed, events = motion(scenario)
    gaps = -np.diff(position, axis=1)
    assert gaps[300] == pytest.approx([15.0] * 7, abs=0.3)
    assert gaps[900] == pytest.approx([15.0, 15.0, 15.0, 35.0, 15.0, 15.0, 15.0], abs=0.5)
    assert gaps.min() > 12.0
    assert speed[900] == pytest.approx([22.0] * 8, abs=0.1)
    logged = [(event.time_ns // S_NS, event.text) for event in events]
    assert logged == [
        (20, "desired speed 22 m/s within 6 s: 1"),
        (30, "desired gap 35 m within 20 s: 5"),
        (90, "desired gap 15 m within 20 s: 5"),
    ]
    assert {event.kind for event in events} == {pb.EVENT_TARGET}


def test_the_first_vehicle_follows_the_ramp_of_its_desired_speed(tmp_path: Path) -> None:
    """The ramp is fed forward whatever k_c is, so the speed lags only by the delay of 0.1 s."""
    text = """
        duration_s: 30
        road: {type: open}
        fleet: {size: 2, gap_m: 200}
        sensors: {error: 0}
        control:
          model: FM
          gains: {k_c: 0.001}
          schedule: [{at_s: 10, vehicles: 1, desired_speed_mps: 20, ramp_s: 10}]
    """
    _, speed, _ = motion(scenario_of(tmp_path, text))
    assert (speed[:101, 0] == 30.0).all()  # as before: it keeps its speed
    assert speed[102:201, 0] == pytest.approx(30.0 - 0.1 * np.arange(1, 100), abs=0.02)
    assert speed[300, 0] == pytest.approx(20.0, abs=0.02)


def test_the_first_vehicle_goes_back_to_its_speed_after_a_brake(tmp_path: Path) -> None:
    """With a desired speed the vehicle cruises, and its error decays with rate k_c."""
    text = """
        duration_s: 20
        road: {type: open}
        fleet: {size: 2, gap_m: 500}
        sensors: {error: 0}
        control:
          model: FM
          schedule: [{at_s: 0, vehicles: 1, desired_speed_mps: 30, gains: {k_c: 0.5}}]
        events: [{vehicle: 1, at_s: 2, duration_s: 2, deceleration_mps2: 3}]
    """
    _, speed, _ = motion(scenario_of(tmp_path, text))
    assert speed[40, 0] == pytest.approx(24.0)
    assert (np.diff(speed[40:, 0]) > 0.0).all()
    missing = 30.0 - speed[45::10, 0]
    shrinks = [after / before for before, after in pairwise(missing[:6].tolist())]
    assert shrinks == pytest.approx([np.exp(-0.5)] * 5, abs=0.04)
