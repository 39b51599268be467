"""A trace is read from a CSV file, and mistakes in the file are reported with their line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.refusals import refusal_of
from tests.scenarios.conftest import Here
from zenvoy.scenarios import (
    Trace,
    effective_yaml,
    load,
)

TRACE = "events:\n- {type: trace, vehicle: 1, at_s: 2, file: drive.csv}\n"
POINTS = ((0.0, 30.0), (0.5, 30.25), (2.0, 28.0))
CSV = "time_s,speed_mps\n0,30\n0.5,30.25\n2,28\n"
NO_HEADER = (
    "events.0.file: no line names a time and a speed, as the header time_s,speed_mps does"
    "  (drive.csv)"
)


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
def test_csv_of_other_programs_is_read(here: Here, csv: str) -> None:
    assert load(here(TRACE, csv)).scenario.events == (Trace(vehicle=1, at_s=2, points=POINTS),)


def test_the_effective_scenario_is_self_contained(here: Here, tmp_path: Path) -> None:
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
def test_mistakes_in_a_csv_are_reported_with_their_line(
    here: Here, csv: str, lines: list[str]
) -> None:
    here(TRACE, csv)
    assert refusal_of("s.yaml").splitlines() == lines


def test_an_unreadable_csv_is_refused(here: Here) -> None:
    here(TRACE, "")
    Path("drive.csv").unlink()
    assert refusal_of("s.yaml").splitlines() == [
        "events.0.file: 'drive.csv' cannot be read: No such file or directory  (s.yaml, line 2)"
    ]
    Path("drive.csv").mkdir()
    assert refusal_of("s.yaml").splitlines() == [
        "events.0.file: 'drive.csv' cannot be read: a folder, not a file  (s.yaml, line 2)"
    ]
    assert refusal_of("s.yaml", 'events.0.file="a\\0b"').splitlines() == [
        "events.0.file: 'a\\x00b' cannot be read: not a valid file name"
        '  (--set events.0.file="a\\0b")'
    ]
    Path("drive.csv").rmdir()
    Path("drive.csv").write_bytes(b"time_s,speed_mps\n0,\xff\n")
    assert refusal_of("s.yaml").splitlines() == [
        "events.0.file: not UTF-8: byte 0xff  (drive.csv, line 2)"
    ]
