"""Each engine runs what it covers, and ends its runs as documented."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Final

import pytest

import zenvoy as api
from tests.conftest import zenvoy
from tests.fleet.engines.conftest import summary
from tests.interrupted import assert_keeps_its_log
from tests.streamed_log import read_log
from zenvoy.analysis.log.load import load

ENGINES: Final = ("in-process", "arrays")


@pytest.mark.parametrize(
    "arguments",
    [
        ("paper/case-15", "--duration-s", "12", "--seed", "3"),
        ("mixed/humans", "--duration-s", "12"),
        ("own.yaml", "--set", "channel.loss.p=0.3"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_arrays_write_the_log_of_the_in_process_bus(here: Path, arguments: tuple[str, ...]) -> None:
    logs = []
    for engine in ENGINES:
        outcome = zenvoy(here, "run", *arguments, "--engine", engine, "--out", engine)
        assert outcome.code == 0, outcome.err
        logs.append(read_log(here / engine / "run.mcap"))
        assert summary(here / engine)["bus"] == engine
    one, other = logs
    assert one.result["fingerprint"] == other.result["fingerprint"]
    assert [message for message in one.messages if message.topic != "/clock"] == [
        message for message in other.messages if message.topic != "/clock"
    ]
    assert [one.result[key] for key in ("end", "cycles")] == [
        other.result[key] for key in ("end", "cycles")
    ]


def test_logged_values_of_a_law_are_read_from_the_log_of_arrays(here: Path) -> None:
    run = api.run("own.yaml", engine="arrays", out="o")
    found = run.estimate["Remembering.gap_error"]
    assert found.shape == (60, 3)
    assert (found[:, 1:] == found[:, 1:]).all()  # the first vehicle has nobody ahead


def test_a_collision_ends_a_run_on_arrays(here: Path) -> None:
    changes = ("--set", "on_collision=stop", "--set", "control.gains.k_d=3")
    for engine in ENGINES:
        run = ("run", "paper/case-01", "--duration-s", "20", *changes, "--out", engine)
        assert zenvoy(here, *run, "--engine", engine).code == 0
    one, other = (summary(here / engine) for engine in ENGINES)
    assert one["collisions"] > 0
    assert one["cycles"] < 200
    assert (one["fingerprint"], one["cycles"]) == (other["fingerprint"], other["cycles"])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_on_arrays_keeps_its_log(here: Path, number: signal.Signals) -> None:
    run = ("own.yaml", "--duration-s", "100000", "--engine", "arrays")
    assert_keeps_its_log(here, number, *run)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_law_that_fails_during_a_run_is_named_with_its_vehicle(here: Path, engine: str) -> None:
    changes = ("--set", "control.parameters.breaks_at=30")
    outcome = zenvoy(here, "run", "own.yaml", *changes, "--engine", engine, "--out", "o")
    assert outcome.code == 3
    expected = "law Remembering raised ZeroDivisionError: float division by zero (pi.py, line 21)"
    assert outcome.err.splitlines()[0] == f"vehicle-02 died: {expected}"
    log = load(here / "o" / "run.mcap")
    assert log.cycles >= 28
    assert log.result["end"] == f"LawError: {expected}"


def test_a_law_that_fails_for_all_at_once_is_named(here: Path) -> None:
    changes = ("--set", "control.model=pi:PICKY")
    outcome = zenvoy(here, "run", "own.yaml", *changes, "--engine", "arrays", "--out", "o")
    assert outcome.code == 3
    expected = "law picky raised ValueError: not two, but only on arrays"
    assert (
        outcome.err.splitlines()[0] == f"the array engine cannot go on: {expected}; in-process can"
    )
    assert load(here / "o" / "run.mcap").result["end"] == f"NotCoveredError: {expected}"
    with pytest.raises(api.RunError, match=f"^the array engine cannot go on: {expected}"):
        api.run(api.scenario("own.yaml", control={"model": "pi:PICKY"}), engine="arrays", out="p")


def test_a_run_on_arrays_reports_its_progress(here: Path) -> None:
    seen: list[api.Progress] = []
    run = api.run("own.yaml", engine="arrays", out="o", on_progress=seen.append)
    assert [progress.time_s for progress in seen] == pytest.approx([0, 1, 2, 3, 4, 5, 6])
    assert run.result["end"] == "complete"
