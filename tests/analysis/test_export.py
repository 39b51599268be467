"""Exported tables are read again and compared with the log."""

from __future__ import annotations

import csv
import math
import resource
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from tests.conftest import zenvoy
from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.log.export import ExportError, Form, export
from zenvoy.analysis.log.load import Run
from zenvoy.bus import messages_pb2 as pb

# Estimates are NaN under BCM, vehicle 1 of the open road has no radar, frames are lost.
SCENARIO = """
duration_s: 2
fleet: {size: 3}
road: {type: open}
channel: {loss: {p: 0.3}}
control: {model: BCM}
events:
  - {vehicle: 2, at_s: 1, duration_s: 0.5, deceleration_mps2: 2}
"""
FILES = ["clock", "truth", "radar", "estimate", "command", "frames", "events"]


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("export") / "run.mcap", SCENARIO)


@pytest.fixture(scope="module")
def run(path: Path) -> Run:
    return load(path)


def read(form: Form, folder: Path, name: str) -> dict[str, list[Any]]:
    """Return the columns of a file as Python values, or as text for CSV."""
    if form == "parquet":
        columns: dict[str, list[Any]] = pyarrow.parquet.read_table(
            folder / f"{name}.parquet"
        ).to_pydict()
        return columns
    with (folder / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return {column: [row[at] for row in rows] for at, column in enumerate(head)}


def same(form: Form, written: list[Any], logged: Any) -> None:
    """Check that numbers are as logged, and None (empty in CSV) where the log has NaN or -1."""
    values = np.asarray(logged).ravel().tolist()
    assert len(written) == len(values)
    for found, value in zip(written, values, strict=True):
        if math.isnan(value) or (isinstance(value, int) and value < 0):
            assert found in {None, ""}
        elif form == "csv":
            assert np.asarray(logged).dtype.type(found) == value
        else:
            assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_written_tables_equal_the_log(run: Run, tmp_path: Path, form: Form) -> None:
    files = export(run, tmp_path / "new" / "folder", form)
    assert files == [tmp_path / "new" / "folder" / f"{name}.{form}" for name in FILES]
    folder = files[0].parent
    assert {file.name for file in folder.iterdir()} == {file.name for file in files}
    truth = read(form, folder, "truth")
    assert list(truth) == [
        "cycle",
        "time_s",
        "vehicle",
        "position_m",
        "speed_mps",
        "acceleration_mps2",
    ]
    same(form, truth["cycle"], np.repeat(run.truth["cycle"], 3))
    same(form, truth["time_s"], np.repeat(run.time_s, 3))
    same(form, truth["vehicle"], [1, 2, 3] * 21)
    for name, column in (("position_m", "position"), ("speed_mps", "speed")):
        same(form, truth[name], run.truth[column])
    radar = read(form, folder, "radar")
    assert np.isnan(run.radar["gap"][:, 0]).all()
    same(form, radar["gap_m"], run.radar["gap"])
    estimate = read(form, folder, "estimate")
    assert np.isnan(run.estimate["ahead_gap"]).all()
    same(form, estimate["ahead_gap_std_m"], run.estimate["ahead_gap_std"])
    same(form, estimate["age_ns"], run.estimate["age_ns"])
    assert set(estimate["neighbours"]) == {None if form == "parquet" else ""}
    assert estimate["mode"] == [
        pb.Mode.Name(mode).removeprefix("MODE_") for mode in run.estimate["mode"].ravel()
    ]
    command = read(form, folder, "command")
    same(form, command["effective_ns"], run.command["effective_ns"])
    same(form, command["acceleration_mps2"], run.command["acceleration"])
    frames = read(form, folder, "frames")
    assert (run.frames["arrived_ns"] == -1).any()
    for name in ("source", "destination", "sequence", "sent_ns", "arrived_ns", "latency_ns"):
        same(form, frames[name], run.frames[name])
    same(form, frames["distance_m"], run.frames["distance"])
    assert set(frames["outcome"]) == {"DELIVERED", "LOST"}
    lost = [outcome == "LOST" for outcome in frames["outcome"]]
    np.testing.assert_array_equal(lost, run.frames["outcome"] == pb.OUTCOME_LOST)
    same(form, read(form, folder, "clock")["wall_ns"], run.clock["wall_ns"])


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_events_are_written_in_words(run: Run, tmp_path: Path, form: Form) -> None:
    export(run, tmp_path, form)
    events = read(form, tmp_path, "events")
    assert events["kind"] == [
        pb.EventKind.Name(event.kind).removeprefix("EVENT_") for event in run.events
    ]
    brake = events["kind"].index("BRAKE")
    found = [events[name][brake] for name in ("cycle", "time_s", "vehicle", "text")]
    assert found == ([10, 1.0, 2, "2 m/s²"] if form == "parquet" else ["10", "1", "2", "2 m/s²"])


def test_parquet_has_types_and_units(run: Run, tmp_path: Path) -> None:
    export(run, tmp_path, "parquet")
    schema = pyarrow.parquet.read_schema(tmp_path / "frames.parquet")
    assert schema.field("latency_ns").metadata == {b"unit": b"ns"}
    assert schema.field("latency_ns").type == pa.int64()
    assert schema.field("distance_m").type == pa.float32()
    schema = pyarrow.parquet.read_schema(tmp_path / "estimate.parquet")
    assert schema.field("ahead_speed_mps").metadata == {b"unit": b"m/s"}
    assert schema.field("ahead_speed_mps").type == pa.float64()
    assert schema.field("cycle").type == pa.uint32()
    assert schema.field("time_s").metadata == {b"unit": b"s"}


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_a_run_without_a_cycle_gives_files_without_a_row(tmp_path: Path, form: Form) -> None:
    short = load(write_log(tmp_path / "short.mcap", SCENARIO, until_cycle=0))
    short = load(cut_before_messages(short.log))
    assert short.truth == {}
    export(short, tmp_path / "x", form)
    whole = load(write_log(tmp_path / "whole.mcap", SCENARIO))
    export(whole, tmp_path / "y", form)
    for name in FILES:
        empty, full = read(form, tmp_path / "x", name), read(form, tmp_path / "y", name)
        assert list(empty) == list(full)
        assert all(column == [] for column in empty.values()), name


def cut_before_messages(path: Path) -> Path:
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"zstd") - 20])
    return path


def test_files_are_replaced_all_or_none_when_the_disk_is_full(path: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "clock.csv").write_text("precious")
    limit = (resource.RLIMIT_FSIZE, 2_000)
    refused = zenvoy(tmp_path, "export", str(path), "--to", "csv", "--out", "out", limit=limit)
    assert (refused.code, refused.out) == (2, "")
    assert refused.err.startswith("--out out: ")
    assert refused.err.count("\n") == 1
    assert [(file.name, file.read_text()) for file in out.iterdir()] == [("clock.csv", "precious")]


def test_files_are_replaced_all_or_none_when_a_folder_is_in_the_way(
    run: Run, tmp_path: Path
) -> None:
    (tmp_path / "events.csv").mkdir()
    (tmp_path / "clock.csv").write_text("precious")
    with pytest.raises(ExportError, match=r"events\.csv is a folder"):
        export(run, tmp_path, "csv")
    assert (tmp_path / "clock.csv").read_text() == "precious"
    assert {file.name for file in tmp_path.iterdir()} == {"clock.csv", "events.csv"}


def test_existing_files_are_replaced(run: Run, tmp_path: Path) -> None:
    (tmp_path / "truth.csv").write_text("old")
    export(run, tmp_path, "csv")
    assert (tmp_path / "truth.csv").read_text().startswith('"cycle","time_s"')


def test_a_file_in_place_of_the_folder_is_refused(run: Run, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("precious")
    with pytest.raises(ExportError, match=r"out: .+"):
        export(run, tmp_path / "out", "parquet")
    assert (tmp_path / "out").read_text() == "precious"


def test_the_command_exports_beside_the_log(path: Path, tmp_path: Path) -> None:
    log = tmp_path / "a.mcap"
    log.write_bytes(path.read_bytes())
    outcome = zenvoy(tmp_path, "export", "a.mcap", "--to", "parquet")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.split() == [f"{name}.parquet" for name in FILES]
    assert all((tmp_path / f"{name}.parquet").exists() for name in FILES)


def test_the_command_exports_a_cut_log_up_to_the_cut(path: Path, tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(path.read_bytes()[:-1])
    outcome = zenvoy(tmp_path, "export", "a.mcap", "--to", "csv", "--out", "x")
    assert outcome.code == 0
    assert outcome.err == "a.mcap: the log is cut: read up to 2 s of 2 s\n"


def test_the_command_refuses_a_file_that_is_no_log(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_text("hello")
    refused = zenvoy(tmp_path, "export", "a.mcap", "--to", "csv", "--out", "x")
    assert (refused.code, refused.out) == (2, "")
    assert refused.err == "a.mcap: not an MCAP file\n"
    assert not (tmp_path / "x").exists()
    refused = zenvoy(tmp_path, "export", "a.mcap", "--to", "hdf5")
    assert refused.code == 2
    assert refused.err == "--to hdf5: is not one of 'parquet', 'csv'\n"
