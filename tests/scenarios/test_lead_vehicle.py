"""A vehicle that follows a speed: exactly, whatever else happens, and as its file says."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from math import pi, sin
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import run, zenvoy
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import (
    Brake,
    Control,
    Road,
    Scenario,
    ScenarioError,
    Sine,
    Trace,
    effective_yaml,
    load,
)
from zenvoy.scenarios import Fleet as FleetSettings
from zenvoy.world.fleet import Fleet

T_NS = 100_000_000
S_NS = 1_000_000_000
MS_NS = 1_000_000


def fleet_with(*events: Brake | Sine | Trace, speed_mps: float = 30.0) -> Fleet:
    return Fleet(
        Scenario(
            road=Road(type="open"),
            fleet=FleetSettings(size=3, gap_m=1_000.0, speed_mps=speed_mps),
            control=Control(model="FM"),
            events=events,
        )
    )


def command(vehicle: int, effective_ns: int, a: float) -> pb.Command:
    return pb.Command(vehicle=vehicle, effective_ns=effective_ns, acceleration=a)


def brake(vehicle: int, at_s: float, duration_s: float, deceleration_mps2: float) -> Brake:
    return Brake(
        vehicle=vehicle, at_s=at_s, duration_s=duration_s, deceleration_mps2=deceleration_mps2
    )


def distance(points: list[tuple[int, float]]) -> float:
    """Under the line through (ns, m/s)."""
    return sum((t1 - t0) / S_NS * (v0 + v1) / 2 for (t0, v0), (t1, v1) in pairwise(points))


def test_the_speed_follows_a_sine_at_every_start_of_a_cycle() -> None:
    swing = Sine(
        vehicle=1, at_s=1.0, duration_s=20.0, mean_mps=30, amplitude_mps=2, frequency_hz=0.1
    )
    fleet = fleet_with(swing)
    start_m = fleet.position[0]
    points = []
    for k in range(1, 301):
        fleet.command([command(1, k * T_NS - 30 * MS_NS, (-1.0) ** k)])  # and is not obeyed
        fleet.advance_to(k * T_NS)
        t = k * 0.1 - 1.0
        if 0.0 <= t <= 20.0:
            points.append((k * T_NS, 30.0 + 2.0 * sin(2 * pi * 0.1 * t)))
            if t > 0.0:
                assert fleet.speed[0] == pytest.approx(points[-1][1], abs=1e-12)
        if k == 10:
            # commands of ±1 m/s² rule up to here, and from the end of the sine on
            start_m, points[0] = fleet.position[0], (k * T_NS, float(fleet.speed[0]))
        if k == 210:
            assert fleet.position[0] - start_m == pytest.approx(distance(points), abs=1e-8)
    assert len(points) == 201
    assert abs(fleet.acceleration[0]) == 1.0
    assert fleet.speed[1:].tolist() == [30.0, 30.0]


def test_a_chirp_sweeps_its_frequency_evenly() -> None:
    """At t its phase is the integral of the frequency: 2π (f t + (f₁ - f) t² / 2D)."""
    chirp = Sine(
        vehicle=1,
        at_s=0.0,
        duration_s=100.0,
        mean_mps=30,
        amplitude_mps=0.5,
        frequency_hz=0.01,
        to_frequency_hz=0.5,
    )
    fleet = fleet_with(chirp)
    t = np.arange(1, 1001) * 0.1
    frequency = 0.01 + 0.49 * np.linspace(0.0, 100.0, 1_000_001) / 100.0
    turns = np.concatenate([[0.0], np.cumsum((frequency[1:] + frequency[:-1]) / 2) * 1e-4])
    expected = 30.0 + 0.5 * np.sin(2 * pi * turns[np.arange(1, 1001) * 1_000])
    speeds = []
    for k in range(1, 1001):
        fleet.advance_to(k * T_NS)
        speeds.append(fleet.speed[0])
    assert t[-1] == pytest.approx(100.0)
    assert speeds == pytest.approx(expected.tolist(), abs=1e-8)


def test_an_unaligned_sine_has_a_point_at_its_end_too() -> None:
    swing = Sine(
        vehicle=1, at_s=0.25, duration_s=0.4, mean_mps=30, amplitude_mps=3, frequency_hz=1.0
    )
    fleet = fleet_with(swing)
    points = [(250 * MS_NS, 30.0)]
    for ms in (300, 400, 500, 600, 650):
        points.append((ms * MS_NS, 30.0 + 3.0 * sin(2 * pi * (ms - 250) / 1e3)))
    start_m = fleet.position[0]
    for k in range(1, 9):
        fleet.advance_to(k * T_NS)
    expected_m = 0.25 * 30.0 + distance(points) + 0.15 * points[-1][1]
    assert fleet.position[0] - start_m == pytest.approx(expected_m, abs=1e-9)
    assert fleet.speed[0] == pytest.approx(points[-1][1], abs=1e-12)
    assert fleet.acceleration[0] == 0.0


steps_ms = st.lists(st.integers(1, 700), min_size=1, max_size=12)
told = st.lists(st.tuples(st.integers(0, 3_000), st.floats(-9.0, 9.0)), max_size=10)


@settings(deadline=None, max_examples=150)
@given(st.integers(0, 500), steps_ms, st.data(), told)
def test_any_trace_is_followed_from_point_to_point(
    at_ms: int, steps: list[int], data: st.DataObject, commands: list[tuple[int, float]]
) -> None:
    """Points at any millisecond, speeds down to standstill, commands that say otherwise."""
    times_ms = np.concatenate([[0], np.cumsum(steps)]).tolist()
    count = len(times_ms)
    speeds = data.draw(st.lists(st.floats(0.0, 40.0), min_size=count, max_size=count))
    trace = Trace(
        vehicle=1,
        at_s=at_ms / 1e3,
        points=tuple((ms / 1e3, v) for ms, v in zip(times_ms, speeds, strict=True)),
    )
    fleet = fleet_with(trace, speed_mps=speeds[0])
    start_m = fleet.position[0]
    late = [(at, a) for at, a in commands if at >= at_ms]  # so that it begins at its first point
    fleet.command([command(1, ms * MS_NS, a) for ms, a in late])
    times_s = (np.array(times_ms) + at_ms) / 1e3
    for k in range(1, (at_ms + times_ms[-1]) // 100 + 1):
        fleet.advance_to(k * T_NS)
        assert fleet.speed[0] == pytest.approx(np.interp(k / 10, times_s, speeds), abs=1e-9)
    fleet.advance_to((at_ms + times_ms[-1]) * MS_NS)
    points = [(round(t * 1e3) * MS_NS, v) for t, v in zip(times_s, speeds, strict=True)]
    expected_m = at_ms / 1e3 * speeds[0] + distance(points)
    assert fleet.position[0] - start_m == pytest.approx(expected_m, abs=1e-7)
    assert fleet.speed[0] == pytest.approx(speeds[-1], abs=1e-9)


def test_errors_do_not_add_up_over_many_points() -> None:
    points = tuple((0.05 * i, 30.0 + (i * 7919 % 101) / 37.0) for i in range(10_001))
    fleet = fleet_with(Trace(vehicle=2, at_s=0.0, points=points))
    for k in range(1, 5_001):
        fleet.advance_to(k * T_NS)
        assert fleet.speed[1] == pytest.approx(points[2 * k][1], abs=1e-12)


def test_a_trace_begins_at_its_first_time_and_ends_at_its_last() -> None:
    fleet = fleet_with(Trace(vehicle=1, at_s=1.0, points=((0.5, 30.0), (1.5, 31.0))))
    fleet.command([command(1, 0, 2.0)])
    fleet.advance_to(1_500 * MS_NS)
    assert fleet.speed[0] == pytest.approx(33.0, abs=1e-12)
    assert fleet.acceleration[0] == pytest.approx(-2.0, abs=1e-9)  # from 33 to 31 m/s within 1 s
    fleet.advance_to(2_500 * MS_NS)
    assert fleet.speed[0] == pytest.approx(31.0, abs=1e-12)
    assert fleet.acceleration[0] == 2.0


@pytest.mark.parametrize("brake_first", [True, False])
def test_a_brake_wins_and_the_trace_is_met_again_at_its_next_point(brake_first: bool) -> None:
    trace = Trace(vehicle=1, at_s=0.0, points=((0.0, 30.0), (2.0, 30.0), (4.0, 32.0)))
    hard = brake(1, 1.0, 0.5, 4.0)
    fleet = fleet_with(*((hard, trace) if brake_first else (trace, hard)))
    fleet.advance_to(S_NS)
    assert fleet.acceleration[0] == -4.0
    fleet.advance_to(1_500 * MS_NS)
    assert fleet.speed[0] == pytest.approx(28.0, abs=1e-12)
    assert fleet.acceleration[0] == pytest.approx(4.0, abs=1e-9)  # 2 m/s within 0.5 s
    fleet.advance_to(2 * S_NS)
    assert fleet.speed[0] == pytest.approx(30.0, abs=1e-12)
    fleet.advance_to(3 * S_NS)
    assert fleet.speed[0] == pytest.approx(31.0, abs=1e-12)


def test_a_vehicle_follows_its_trace_into_a_collision() -> None:
    """Vehicle 2 at 10 m/s, vehicle 1 stands: touching bumpers, and no speed beyond reason."""
    fleet = fleet_with(Trace(vehicle=2, at_s=0.0, points=((0.0, 10.0), (200.0, 10.0))))
    fleet.speed = np.array([0.0, 10.0, 0.0])
    collided = [k for k in range(1, 1_100) if fleet.advance_to(k * T_NS)]
    assert collided[0] == 996  # 995 m at 10 m/s, and then within the cycle
    assert fleet.position[0] - fleet.position[1] == pytest.approx(5.0, abs=1e-8)
    assert fleet.speed[1] == 0.0


SCENARIO = """
duration_s: 6
road: {type: open}
fleet: {size: 4}
control: {model: FM}
sensors: {error: 0}
events:
  - {type: brake, vehicle: 3, at_s: 2, duration_s: 1, deceleration_mps2: 1}
  - {type: sine, vehicle: 1, at_s: 1, duration_s: 3, amplitude_mps: 1, frequency_hz: 0.5}
  - {type: trace, vehicle: 1, at_s: 4.05, file: drive.csv}
"""


@pytest.mark.parametrize("bus", ["in-process", "zenoh"])
def test_the_log_tells_of_traces_and_shows_them(tmp_path: Path, bus: str) -> None:
    csv = tmp_path / "out"
    csv.mkdir()
    (csv / "drive.csv").write_text("time_s,speed_mps\n0,30\n1,31.5\n")
    scenario = SCENARIO.replace("drive.csv", str(csv / "drive.csv"))
    log = run(tmp_path / "run", scenario, "--bus", bus)
    events = [pb.Event.FromString(message.data) for message in log.of("/events")]
    assert [(e.time_ns / S_NS, e.kind, e.vehicle, e.text) for e in events] == [
        (1.0, pb.EVENT_TRACE, 1, "sine, 30 ± 1 m/s, 0.5 Hz"),
        (2.0, pb.EVENT_BRAKE, 3, "1 m/s²"),
        (3.0, pb.EVENT_BRAKE_END, 3, ""),
        (4.0, pb.EVENT_TRACE_END, 1, ""),
        (4.05, pb.EVENT_TRACE, 1, "trace of 2 points"),
        (5.05, pb.EVENT_TRACE_END, 1, ""),
    ]
    truth = [pb.FleetTruth.FromString(message.data) for message in log.of("/fleet/truth")]
    speed = [row.speed[0] for row in truth]
    for k in range(10, 41):
        assert speed[k] == pytest.approx(30 + sin(pi * (k / 10 - 1.0)), abs=1e-12)
    for k in range(41, 51):
        assert speed[k] == pytest.approx(30 + 1.5 * (k / 10 - 4.05), abs=1e-12)
    assert speed[51:] == [pytest.approx(31.5, abs=1e-12)] * 10  # it keeps the speed it has then
    values = json.loads(log.attachments["effective.json"])
    assert values["events"][2]["points"] == [[0.0, 30.0], [1.0, 31.5]]


# What scenarios say -------------------------------------------------------------------------

Here = Callable[[str, str], Path]
TRACE = "events:\n- {type: trace, vehicle: 1, at_s: 2, file: drive.csv}\n"
POINTS = ((0.0, 30.0), (0.5, 30.25), (2.0, 28.0))
CSV = "time_s,speed_mps\n0,30\n0.5,30.25\n2,28\n"

NO_HEADER = (
    "events.0.file: no line names a time and a speed, as the header time_s,speed_mps does"
    "  (drive.csv)"
)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Here:
    """Writes s.yaml and drive.csv into the current folder."""
    monkeypatch.chdir(tmp_path)

    def write(text: str, csv: str) -> Path:
        Path("s.yaml").write_text(text)
        Path("drive.csv").write_bytes(csv.encode())
        return Path("s.yaml")

    return write


def refusal(*arguments: str) -> list[str]:
    with pytest.raises(ScenarioError) as caught:
        load("s.yaml", arguments)
    return str(caught.value).splitlines()


def test_a_trace_has_the_points_of_its_file(here: Here) -> None:
    scenario = load(here(TRACE, CSV)).scenario
    assert scenario.events == (Trace(vehicle=1, at_s=2.0, points=POINTS),)
    assert (scenario.profiles, scenario.brakes) == (scenario.events, ())


@pytest.mark.parametrize(
    "csv",
    [
        CSV.replace("\n", "\r\n"),
        "\ufeff" + CSV,
        CSV.replace(",", " , ") + "\n\n",
        '"time_s","speed_mps"\n0,"30"\n5e-1,3.025e1\n2.,+28.\n',
    ],
)
def test_csv_as_other_programs_write_it(here: Here, csv: str) -> None:
    assert load(here(TRACE, csv)).scenario.events == (Trace(vehicle=1, at_s=2, points=POINTS),)


def test_the_effective_scenario_is_complete_in_itself(here: Here, tmp_path: Path) -> None:
    scenario = load(here(TRACE, CSV)).scenario
    text = effective_yaml(scenario)
    assert "  points:\n  - [0.0, 30.0]\n  - [0.5, 30.25]\n  - [2.0, 28.0]\n" in text
    assert "file" not in text
    Path("drive.csv").unlink()
    assert load(here(text, "")).scenario == scenario
    shown = zenvoy(tmp_path, "show", "s.yaml")
    assert (shown.code, shown.out) == (0, text)


def test_a_file_is_relative_to_the_scenario_that_names_it(here: Here) -> None:
    here("extends: sub/base.yaml\n", "nothing of use")
    Path("sub").mkdir()
    Path("sub/base.yaml").write_text(TRACE)
    Path("sub/drive.csv").write_text(CSV)
    assert load("s.yaml").scenario.events == (Trace(vehicle=1, at_s=2, points=POINTS),)


def test_a_setting_names_a_file_from_the_folder_of_the_command(here: Here) -> None:
    here("{}", CSV)
    Path("sub").mkdir()
    Path("sub/s.yaml").write_text(TRACE.replace("drive.csv", "other.csv"))
    events = load("sub/s.yaml", ["events.0.file=drive.csv"]).scenario.events
    assert events == (Trace(vehicle=1, at_s=2, points=POINTS),)
    given = load("sub/s.yaml", ["events.0.points=[[0, 1], [1, 2]]"]).scenario.events
    assert given == (Trace(vehicle=1, at_s=2, points=((0.0, 1.0), (1.0, 2.0))),)


@pytest.mark.parametrize(
    ("csv", "lines"),
    [
        (
            "0,30\n1,31\n",
            [NO_HEADER],
        ),
        (
            "",
            [NO_HEADER],
        ),
        (
            "time_s,speed_mps\n0,30\nsoon,31\n2,\n3\n4,5,6\n",
            [
                "events.0.file: time_s: 'soon' is not a number  (drive.csv, line 3)",
                "events.0.file: a row of 1 is not a row of 2, time_s, speed_mps"
                "  (drive.csv, line 5)",
                "events.0.file: a row of 3 is not a row of 2, time_s, speed_mps"
                "  (drive.csv, line 6)",
            ],
        ),
        (
            "time_s,speed_mps\n0,inf\n1,1_0\n",
            [
                "events.0.file: speed_mps: 'inf' is not a number  (drive.csv, line 2)",
                "events.0.file: speed_mps: '1_0' is not a number  (drive.csv, line 3)",
            ],
        ),
        (
            "time_s,speed_mps\n0,30\n1,-2\n-1,1e999\n",
            [
                "events.0.points.1.1: -2.0 is not in [0, 1e9]  (drive.csv, line 3)",
                "events.0.points.2.0: -1.0 is not in [0, 1e9]  (drive.csv, line 4)",
                "events.0.points.2.1: inf is not in [0, 1e9]  (drive.csv, line 4)",
            ],
        ),
        (
            "time_s,speed_mps\n0,30\n2,31\n\n2,32\n1.5,33\n",
            [
                "events.0.points.2.0: 2 is not later than the point before (2)"
                "  (drive.csv, line 5)",
                "events.0.points.3.0: 1.5 is not later than the point before (2)"
                "  (drive.csv, line 6)",
            ],
        ),
        (
            "time_s,speed_mps\n0,30\n",
            ["events.0.points: a list of 1 is not a list of 2 to 60000 points  (drive.csv)"],
        ),
        (
            "time_s,speed_mps\n" + "".join(f"{i},1\n" for i in range(60_001)),
            ["events.0.points: a list of 60001 is not a list of 2 to 60000 points  (drive.csv)"],
        ),
    ],
)
def test_what_is_wrong_in_a_csv_is_told_with_its_line(
    here: Here, csv: str, lines: list[str]
) -> None:
    here(TRACE, csv)
    assert refusal() == lines


def test_a_csv_that_cannot_be_read(here: Here) -> None:
    here(TRACE, "")
    Path("drive.csv").unlink()
    assert refusal() == [
        "events.0.file: 'drive.csv' cannot be read: No such file or directory  (s.yaml, line 2)"
    ]
    Path("drive.csv").mkdir()
    assert refusal() == [
        "events.0.file: 'drive.csv' cannot be read: a folder, not a file  (s.yaml, line 2)"
    ]
    assert refusal('events.0.file="a\\0b"') == [
        "events.0.file: 'a\\x00b' cannot be read: not a valid file name"
        '  (--set events.0.file="a\\0b")'
    ]
    Path("drive.csv").rmdir()
    Path("drive.csv").write_bytes(b"time_s,speed_mps\n0,\xff\n")
    assert refusal() == ["events.0.file: not UTF-8: byte 0xff  (drive.csv, line 2)"]


HEAD = "events:\n- {type: trace, vehicle: 1, at_s: 0"
WAVE = "events:\n- {type: sine, vehicle: 1, at_s: 0, duration_s: 100, "


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (f"{HEAD}}}", ["events.0: neither file nor points is given; allowed: one of the two"]),
        (
            f"{HEAD}, file: drive.csv, points: [[0, 1], [1, 1]]}}",
            ["events.0.file: given together with points; allowed: one of the two"],
        ),
        (f"{HEAD}, file: 3}}", ["events.0.file: 3 is not text, the name of a CSV file"]),
        (f"{HEAD}, points: 3}}", ["events.0.points: 3 is not a list"]),
        (
            f"{HEAD}, points: [[0, 1]]}}",
            ["events.0.points: a list of 1 is not a list of 2 to 60000 points"],
        ),
        (
            f"{HEAD}, points: [[0, 1], 3, [2], [3, 4, 5], [], [x, -1]]}}",
            [
                "events.0.points.1: 3 is not a list of 2",
                "events.0.points.2.1: missing; allowed: a number in [0, 1e9]",
                "events.0.points.3: a list of 3 is not a list of 2",
                "events.0.points.4.0: missing; allowed: a number in [0, 1e9]",
                "events.0.points.4.1: missing; allowed: a number in [0, 1e9]",
                "events.0.points.5.0: 'x' is not a number",
                "events.0.points.5.1: -1 is not in [0, 1e9]",
            ],
        ),
        (
            f"{HEAD}, points: [[0, 1], [1, 2]], deceleration_mps2: 3}}",
            [
                "events.0.deceleration_mps2: unknown key; allowed: type, vehicle, at_s, file, "
                "column, time_column, unit, time_unit, time, where, points"
            ],
        ),
        (
            f"{WAVE}amplitud_mps: 1, frequency_hz: 0.1}}",
            [
                "events.0.amplitude_mps: missing; allowed: a number in [0, 1e9]",
                "events.0.amplitud_mps: unknown key; did you mean 'amplitude_mps'? allowed: type, "
                "vehicle, at_s, duration_s, mean_mps, amplitude_mps, frequency_hz, to_frequency_hz",
            ],
        ),
        (
            f"{WAVE}amplitude_mps: 31, frequency_hz: 0.1}}",
            ["events.0.amplitude_mps: 31 is not in [0, 30], up to mean_mps (30)"],
        ),
        (
            f"{WAVE}amplitude_mps: 1, frequency_hz: 5, to_frequency_hz: 4.9}}",
            [
                "events.0.frequency_hz: 5 is not less than 5, half the rate of period_ms (100)",
            ],
        ),
        (
            f"{WAVE}amplitude_mps: 1, frequency_hz: 0.1, to_frequency_hz: fast}}",
            ["events.0.to_frequency_hz: 'fast' is not a number or null"],
        ),
        (
            f"{WAVE}amplitude_mps: 1, frequency_hz: 0, to_frequency_hz: 7}}",
            [
                "events.0.frequency_hz: 0 is not in (0, 1e9]",
                "events.0.to_frequency_hz: 7 is not less than 5, half the rate of period_ms (100)",
            ],
        ),
        (
            f"{HEAD}, vehicle: 41, points: [[0, 1], [1, 2]]}}".replace("vehicle: 1, ", ""),
            ["events.0.vehicle: 41 is not in [1, 40], the vehicles of fleet.size (40)"],
        ),
    ],
)
def test_what_an_event_may_not_say(here: Here, text: str, lines: list[str]) -> None:
    here(text, CSV)
    assert refusal() == [f"{line}  (s.yaml, line 2)" for line in lines]


OVERLAP = """
events:
- {type: sine, vehicle: 1, at_s: 10, duration_s: 100, amplitude_mps: 1, frequency_hz: 0.1}
- {type: trace, vehicle: 1, at_s: 100, points: [[10, 30], [20, 31]]}
- {type: trace, vehicle: 2, at_s: 100, points: [[0, 30], [20, 31]]}
- {type: brake, vehicle: 1, at_s: 20, duration_s: 5, deceleration_mps2: 3}
"""


def test_speeds_of_one_vehicle_do_not_overlap(here: Here) -> None:
    assert len(load(here(OVERLAP, "")).scenario.profiles) == 3  # they touch
    assert refusal("events.1.at_s=99.9") == [
        "events.1: begins at 109.9 s, before events.0 of the same vehicle ends (110 s)"
        "  (--set events.1.at_s=99.9)",
    ]
    assert refusal("events.1.at_s=99.9", "events.2.vehicle=1") == [
        "events.2: begins at 100 s, before events.0 of the same vehicle ends (110 s)"
        "  (--set events.2.vehicle=1)",
        "events.1: begins at 109.9 s, before events.2 of the same vehicle ends (120 s)"
        "  (--set events.2.vehicle=1)",
    ]


def test_a_refused_value_does_not_make_speeds_overlap(here: Here) -> None:
    here(OVERLAP, "")
    assert refusal("events.1.points=[]") == [
        "events.1.points: a list of 0 is not a list of 2 to 60000 points"
        "  (--set events.1.points=[])"
    ]
    assert refusal("events.1.at_s=soon") == [
        "events.1.at_s: 'soon' is not a number  (--set events.1.at_s=soon)"
    ]
