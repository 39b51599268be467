"""Scenarios read published tables of speeds, and refuse wrong options of them."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests import recordings as forms
from zenvoy.scenarios import ScenarioError, Trace, load


@pytest.fixture
def event(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str | bytes, str], Any]:
    """Return a function that reads drive.csv through a scenario, and returns the event."""
    monkeypatch.chdir(tmp_path)

    def read(data: str | bytes, keys: str, name: str = "drive.csv") -> Any:
        Path(name).write_bytes(data.encode() if isinstance(data, str) else data)
        head = f"type: trace, vehicle: 1, at_s: 0, file: {name}"
        Path("s.yaml").write_text(f"events:\n- {{{head}, {keys}}}\n")
        return load("s.yaml").scenario.events[0]

    return read


def test_a_scenario_reads_a_file_of_the_openacc_dataset(event: Callable[..., Any]) -> None:
    keys = "column: Speed1, unit: m/s, time: from-first"
    points = ((0.0, 8.25), (0.1, 8.5), (0.2, 8.625), (0.30000000000001, 8.75))
    trace = Trace(vehicle=1, at_s=0.0, points=points)
    assert event(forms.OPENACC, keys) == trace
    packed = gzip.compress(forms.OPENACC.encode())
    assert event(packed, keys, "drive.csv.gz") == trace


def test_a_scenario_reads_one_vehicle_of_many(event: Callable[..., Any]) -> None:
    assert event(forms.FCD, "unit: mps, where: {vehicle_id: f.0}").points[0] == (0.1, 27.5)
    assert event(forms.PLEXE, "unit: m/s, where: {nodeId: 1, run: 0.0}").points[0] == (0.1, 27.5)


def test_a_scenario_reads_an_hour_at_ten_hertz(event: Callable[..., Any]) -> None:
    rows = "".join(f"{n / 10};{n % 50},5\n" for n in range(36_001))
    points = event("Time [s];Speed [km/h]\n" + rows, "").points
    assert (len(points), points[-1][0], points[1][1]) == (36_001, 3_600.0, 15 / 36)


@pytest.mark.parametrize(
    ("keys", "lines"),
    [
        (
            "column: Speed7, unit: m/s",
            [
                "events.0.column: 'Speed7' is not a column; allowed: one of Speed1, Speed2"
                "  (s.yaml, line 2)"
            ],
        ),
        (
            "column: Speed1",
            [
                "events.0.unit: not given, and 'Speed1' names no unit; allowed: one of m/s, km/h, "
                "mph, knots  (drive.csv, line 6)"
            ],
        ),
        (
            "column: [a], time_column: true, unit: furlongs, time_unit: 3, time: now, "
            "where: {a: []}",
            [
                "events.0.column: a list is not text, the name of a column  (s.yaml, line 2)",
                "events.0.time_column: true is not text, the name of a column  (s.yaml, line 2)",
                "events.0.unit: 'furlongs' is not one of m/s, km/h, mph, knots  (s.yaml, line 2)",
                "events.0.time_unit: 3 is not one of s, ms, us, ns, min  (s.yaml, line 2)",
                "events.0.time: 'now' is not one of as-given, from-first  (s.yaml, line 2)",
                "events.0.where: a mapping is not a mapping from columns to values"
                "  (s.yaml, line 2)",
            ],
        ),
    ],
)
def test_wrong_options_of_a_file_are_refused(
    event: Callable[..., Any], keys: str, lines: list[str]
) -> None:
    with pytest.raises(ScenarioError) as caught:
        event(forms.OPENACC, keys)
    assert str(caught.value).splitlines() == lines


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (gzip.compress(forms.EPA.encode(), mtime=0) + b"more", "not a gzip file"),
        (forms.EPA.encode(), "not a gzip file"),
        (gzip.compress(forms.EPA.encode(), mtime=0)[:-9], "its end is missing"),
        (gzip.compress(b"0" * (17 << 20), mtime=0), "larger than the limit of 16 MiB"),
    ],
    ids=["more", "text", "cut", "huge"],
)
def test_damaged_and_huge_gzip_files_are_refused(
    event: Callable[..., Any], data: bytes, why: str
) -> None:
    with pytest.raises(ScenarioError) as caught:
        event(data, "unit: mph", "drive.csv.gz")
    place = "(s.yaml, line 2)"
    assert str(caught.value) == f"events.0.file: 'drive.csv.gz' cannot be read: {why}  {place}"


def test_options_of_a_file_without_a_file_are_refused(tmp_path: Path) -> None:
    head = "{type: trace, vehicle: 1, at_s: 0, points: [[0, 1], [1, 2]], unit: km/h}"
    (tmp_path / "s.yaml").write_text(f"events:\n- {head}\n")
    with pytest.raises(ScenarioError, match=r"events\.0\.unit: given without a file"):
        load(tmp_path / "s.yaml")
