"""Vehicles send beacons every cycle, every n-th cycle, or by the triggers of ETSI's CAMs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.logs import write_log
from tests.refused import refused
from zenvoy.analysis import load as load_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Beacons, Estimator, Scenario, Sensors
from zenvoy.vehicles.beaconing import EtsiCam, beaconing
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.state import SpeedState

MS_NS = 1_000_000


def cams(motion: Sequence[tuple[float, float]], period_ms: int = 100) -> list[int]:
    """Return the cycles with a CAM of a vehicle with this motion, read without error."""
    own, period_ns = Motion(10 * 1_000 * MS_NS), period_ms * MS_NS
    speed = SpeedState(period_ns, Estimator(), ReadingError(1e-6, 30.0, 1e-6), own)
    rule, before = EtsiCam(speed, own, period_ns), motion[0][1]
    sent: list[int] = []
    for cycle, (position, v) in enumerate(motion):
        acceleration = (v - before) / (period_ms * 1e-3)
        before = v
        sense = pb.Sense(
            cycle=cycle,
            time_ns=cycle * period_ms * MS_NS,
            position=position,
            speed=v,
            acceleration=acceleration,
        )
        number = rule.next(sense)
        if number is not None:
            assert number == len(sent)
            sent.append(cycle)
    return sent


def test_a_vehicle_that_takes_over_numbers_beacons_beyond_those_of_the_other() -> None:
    rule = beaconing(Scenario(beacons=Beacons(rule="etsi-cam")), 5)
    senses = [pb.Sense(cycle=k, time_ns=k * 100 * MS_NS, position=9.0 * k) for k in (70, 71, 72)]
    assert [rule.next(sense) for sense in senses] == [70, 71, 72]


def steady(speed: float, cycles: int, period_ms: int = 100) -> list[tuple[float, float]]:
    return [(speed * k * period_ms * 1e-3, speed) for k in range(cycles)]


@pytest.mark.parametrize(
    ("speed", "every"),
    [(0.0, 10), (3.0, 10), (4.1, 10), (10.0, 5), (14.0, 3), (30.0, 2), (39.0, 2), (41.0, 1)],
)
def test_a_cam_is_sent_after_four_metres_or_a_second(speed: float, every: int) -> None:
    assert cams(steady(speed, 60)) == list(range(0, 60, every))


def test_cams_are_at_least_100_ms_apart() -> None:
    sent = cams(steady(200.0, 100, period_ms=20), period_ms=20)
    assert set(np.diff(sent)) == {5}


def test_a_change_of_speed_triggers_a_cam() -> None:
    """The speed rises by 0.4 m/s per cycle, so it passes 0.5 m/s every second cycle."""
    motion = [(0.0, 0.0)] * 5 + [(0.0, 0.4 * k) for k in range(1, 9)]
    assert cams(motion) == [0, 6, 8, 10, 12]


def test_the_interval_of_a_trigger_holds_for_three_more() -> None:
    """After a jump of 5 m at 300 ms the vehicle stands: three intervals of 300 ms, then 1 s."""
    places = [0.0] * 3 + [5.0] * 40
    sent = cams([(place, 0.0) for place in places])
    assert sent == [0, 3, 6, 9, 12, 22, 32, 42]


@given(
    st.lists(st.tuples(st.floats(-8.0, 8.0), st.floats(0.0, 50.0)), min_size=2, max_size=60),
    st.sampled_from([50, 100, 300]),
)
def test_cams_keep_their_bounds_and_thresholds(
    steps: list[tuple[float, float]], period_ms: int
) -> None:
    position, motion = 0.0, []
    for step, speed in steps:
        position += step
        motion.append((position, speed))
    sent = cams(motion, period_ms)
    assert sent[0] == 0
    gaps_ms = np.diff([*sent, len(motion) - 1 + (1000 // period_ms)]) * period_ms
    assert (np.diff(sent) * period_ms >= 100).all()
    assert (gaps_ms[:-1] < 1000 + period_ms).all()
    last = 0
    for cycle in range(1, len(motion)):
        moved = abs(motion[cycle][0] - motion[last][0]) > 4.0
        if moved and (cycle - last) * period_ms >= 100:
            assert cycle in sent
        if cycle in sent:
            last = cycle


def beacons_of(beacons: Beacons, cycles: int = 30) -> list[list[int | None]]:
    """Return the sequence numbers of vehicles 1 to 7 under a control period of 20 ms, by cycle."""
    scenario = Scenario(period_ms=20.0, beacons=beacons)
    rules = [beaconing(scenario, vehicle) for vehicle in range(1, 8)]
    return [[rule.next(pb.Sense(cycle=cycle)) for rule in rules] for cycle in range(cycles)]


@pytest.mark.parametrize("n", [1, 3, 7])
def test_every_nth_cycle_is_staggered_over_vehicles(n: int) -> None:
    found = beacons_of(Beacons(rule="every-nth", every=n))
    for cycle, numbers in enumerate(found):
        for vehicle, number in enumerate(numbers):
            turn, rest = divmod(cycle - vehicle % n, n)
            assert number == (turn if rest == 0 and turn >= 0 else None)
    assert beacons_of(Beacons(period_ms=20.0 * n, staggered=True)) == found


@pytest.mark.parametrize("n", [1, 3, 7])
def test_a_beacon_period_of_its_own_is_the_same_for_all_vehicles(n: int) -> None:
    for cycle, numbers in enumerate(beacons_of(Beacons(period_ms=20.0 * n))):
        turn, rest = divmod(cycle, n)
        assert numbers == [None if rest else turn] * 7


def test_by_default_a_vehicle_sends_in_every_cycle() -> None:
    rule = beaconing(Scenario(), 5)
    assert [rule.next(pb.Sense(cycle=cycle)) for cycle in range(5)] == list(range(5))
    assert Scenario().beacons == Beacons(rule="every-cycle", every=1)


RUN = """
duration_s: 12
fleet: {{size: 5, speed_mps: {speed}}}
control: {{desired_speed_mps: {speed}}}
sensors: {{error: 0.05}}
beacons: {{rule: {rule}}}
"""


@pytest.mark.parametrize(
    ("rule", "speed", "least", "most"),
    [
        ("every-cycle", 30, 120, 120),
        ("every-nth, every: 4", 30, 30, 30),
        ("every-cycle, period_ms: 400", 30, 30, 30),
        ("etsi-cam", 30, 60, 64),
        ("etsi-cam", 0, 12, 12),
    ],
)
def test_a_run_has_the_frames_of_its_rule(
    tmp_path: Path, rule: str, speed: int, least: int, most: int
) -> None:
    run = load_log(write_log(tmp_path / "run.mcap", RUN.format(rule=rule, speed=speed)))
    frames = run.frames
    for vehicle in range(1, 6):
        mine = frames["source"] == vehicle
        numbers = np.unique(frames["sequence"][mine])
        assert numbers.tolist() == list(range(len(numbers)))
        assert least <= len(numbers) <= most
        assert mine.sum() == 4 * len(numbers)


def test_errors_of_readings_trigger_nothing() -> None:
    """Readings of speed have errors up to 10 %, 3 m/s, but CAMs use the filtered speed."""
    scenario = Scenario(beacons=Beacons(rule="etsi-cam"), sensors=Sensors(error=0.1))
    rule, random = beaconing(scenario, 1), np.random.default_rng(1)
    sent = 0
    for cycle in range(600):
        speed = 10.0 * (1.0 + random.uniform(-0.1, 0.1))
        sense = pb.Sense(
            cycle=cycle, time_ns=cycle * 100 * MS_NS, position=1.0 * cycle, speed=speed
        )
        sent += rule.next(sense) is not None
    assert sent < 600 / 5 * 1.25  # one in five cycles by position


def test_wrong_settings_are_refused(tmp_path: Path) -> None:
    for text, line in [
        ("{rule: cam}", "beacons.rule: 'cam' is not one of every-cycle, every-nth, etsi-cam"),
        ("{every: 3}", "beacons.every: 3 is given, but beacons.rule is every-cycle; allowed: 1"),
        ("{rule: every-nth, every: 0}", "beacons.every: 0 is not in [1, 1000]"),
        ("{period_ms: 250}", "beacons.period_ms: 250 is not a multiple of period_ms (100)"),
        ("{period_ms: 50}", "beacons.period_ms: 50 is not a multiple of period_ms (100)"),
        ("{period_ms: 0}", "beacons.period_ms: 0 is not in [1, 1e6]"),
        (
            "{rule: etsi-cam, period_ms: 200}",
            "beacons.period_ms: 200 is given, but beacons.rule is etsi-cam; allowed: null",
        ),
        (
            "{rule: every-nth, every: 2, staggered: true}",
            "beacons.staggered: true needs beacons.period_ms; allowed without: false",
        ),
    ]:
        (found,) = refused(tmp_path, f"beacons: {text}\n")
        assert found.startswith(line)
