"""`zenvoy trace` shows what a scenario would read from a file: numbers, a picture, and YAML."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tests import recordings
from tests.conftest import zenvoy
from zenvoy.scenarios import load


def figures(path: Path) -> dict[tuple[str, str], float]:
    """Return the values of a table by figure and unit."""
    _, *rows = csv.reader(path.read_text().splitlines())
    return {(figure, unit): float(value) for figure, unit, value in rows}


def test_a_trace_is_compared_with_the_limits(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time_s,speed_kmh\n0,0\n1,0\n2,18\n4,18\n5,0\n")
    outcome = zenvoy(tmp_path, "trace", "a.csv", "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")
    found = figures(tmp_path / "out" / "trace-motion.csv")
    assert found["duration", "s"] == 5.0
    assert found["distance", "km"] == pytest.approx(0.015)
    assert found["speed, largest", "m/s"] == found["speed, largest", "km/h"] / 3.6 == 5.0
    assert found["standstill", "s"] == 1.0
    assert found["acceleration, largest", "m/s²"] == found["deceleration, largest", "m/s²"] == 5.0
    assert (found["limit of commands", "m/s²"], found["beyond the limit", "s"]) == (3.0, 2.0)
    assert "2 of 4 steps are beyond ±3 m/s²" in " ".join(outcome.out.split())
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "trace.png",
        "trace.svg",
        "trace.html",
        "trace-motion.csv",
        "trace-reading.csv",
    }


def test_the_printed_scenario_reads_the_same_trace(tmp_path: Path) -> None:
    (tmp_path / "oa.csv").write_text(recordings.OPENACC)
    options = ("--column", "Speed2", "--unit", "m/s", "--time", "from-first")
    outcome = zenvoy(tmp_path, "trace", "oa.csv", *options, "--where", "N1=68.75", "--out", "out")
    assert outcome.code == 2  # one row is no trace
    assert outcome.err == "a list of 1 is not a list of 2 to 60000 points  (oa.csv)\n"
    outcome = zenvoy(tmp_path, "trace", "oa.csv", *options, "--out", "out")
    assert outcome.code == 0
    printed = outcome.out[outcome.out.index("events:") : outcome.out.index("\nout/")]
    assert YAML(typ="safe").load(printed)["events"][0]["column"] == "Speed2"
    (tmp_path / "s.yaml").write_text(printed.replace("oa.csv", str(tmp_path / "oa.csv")))
    (trace,) = load(tmp_path / "s.yaml").scenario.profiles
    assert (trace.start_ns, trace.end_ns) == (0, 200_000_000)
    read = dict(csv.reader((tmp_path / "out" / "trace-reading.csv").read_text().splitlines()))
    assert read["rows without a speed, left out"] == "2"
    assert read["longest time without a speed, s"] == "0.2"
    assert read["speeds slightly below 0, set to 0"] == "1"
    assert read["first time, as written"] == "780.1"


def test_a_clock_of_1970_is_reported(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time_s,speed_mps\n43200,3\n43201,4\n")
    outcome = zenvoy(tmp_path, "trace", "a.csv", "--out", "out")
    assert outcome.code == 0
    assert "begins 43200 s after" in " ".join(outcome.out.split())
    assert "time: from-first" in " ".join(outcome.out.split())


@pytest.mark.parametrize(
    ("arguments", "err"),
    [
        (["none.csv"], "'none.csv' cannot be read: No such file or directory"),
        (
            ["oa.csv"],
            "--column: not given, and no column is called a speed; allowed: one of Speed1, Speed2"
            "  (oa.csv, line 6)",
        ),
        (
            ["oa.csv", "--column", "Speed1", "--unit", "c"],
            "--unit: 'c' is not one of m/s, km/h, mph, knots",
        ),
        (
            ["oa.csv", "--column", "Speed1"],
            "--unit: not given, and 'Speed1' names no unit; allowed: one of m/s, km/h, mph, knots"
            "  (oa.csv, line 6)",
        ),
        (
            ["oa.csv", "--where", "a"],
            "--where a: is not of the form COLUMN=VALUE, each column once",
        ),
        (["oa.csv", "--limit-mps2", "nan"], "--limit-mps2 nan: is not a number above 0"),
        (["back.csv"], "1 is not later than the point before (1)  (back.csv, line 3)"),
        (["below.csv"], "-2.0 is not in [0, 1e9]  (below.csv, line 3)"),
    ],
)
def test_files_that_cannot_be_shown_are_refused(
    tmp_path: Path, arguments: list[str], err: str
) -> None:
    (tmp_path / "oa.csv").write_text(recordings.OPENACC)
    (tmp_path / "back.csv").write_text("time_s,speed_mps\n1,1\n1,2\n")
    (tmp_path / "below.csv").write_text("time_s,speed_mps\n1,1\n2,-2\n")
    outcome = zenvoy(tmp_path, "trace", *arguments, "--out", "out")
    assert (outcome.code, outcome.err) == (2, f"{err}\n")
    assert not (tmp_path / "out").exists()
