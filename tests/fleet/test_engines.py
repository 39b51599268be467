"""Each engine runs what it covers, refuses the rest, and ends its runs as documented."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any, Final

import pytest

import zenvoy as api
from tests.conftest import Outcome, read_log, zenvoy
from tests.interrupted import assert_keeps_its_log
from zenvoy.analysis.log.load import load

ENGINES: Final = ("in-process", "arrays")
LAW: Final = '''\
"""Follows the vehicle ahead, and remembers how far it was from its desired gap."""

from dataclasses import dataclass

from zenvoy.laws import Column, Law, Output, clipped, where


@dataclass(frozen=True)
class Parameters:
    gain: float = 0.1
    breaks_at: float = 1e9


def acceleration(seen, own):
    cycles, integral = seen.state
    error = seen.ahead.p - seen.setpoint.p_des
    integral = integral + error * seen.period_s
    k_d = where(error < 0.0, 2.0 * own.gain, own.gain)
    a = k_d * error + 0.5 * seen.ahead.v + clipped(0.01 * integral, 0.2)
    a = a + 0.01 * (seen.uniform(0) - 0.5)
    late = 1.0 / (cycles - own.breaks_at)
    return Output(a + 0.0 * late, logged=(error, late), state=(cycles + 1.0, integral))


LAW = Law(
    name="Remembering",
    acceleration=acceleration,
    parameters=Parameters,
    columns=(Column("gap_error", "m"), Column("late", "1")),
    state=(0.0, 0.0),
)


def branching(seen, own):
    if seen.ahead.p < 20.0:
        return -1.0
    return 0.1 * seen.ahead.v


BRANCHING = Law(name="branching", acceleration=branching)


def picky(seen, own):
    if getattr(seen.speed, "shape", None) == (2,):
        raise ValueError("not\\ntwo")
    return 0.1 * seen.ahead.v


PICKY = Law(name="picky", acceleration=picky)


class Ended(BaseException):
    pass


def ending(seen, own):
    raise Ended("for good")


ENDING = Law(name="ending", acceleration=ending)
'''
OWN: Final = """
duration_s: 6
road: {type: open}
fleet: {size: 3, speed_mps: 28}
control: {model: "pi:LAW", desired_speed_mps: 28}
"""
NOT_COVERED: Final = {
    "channel.medium.access=csma": "channel.medium.access: csma does not run on arrays; "
    "allowed: none",
    "channel.relay_hops=3": "channel.relay_hops: 3 does not run on arrays; allowed: 1",
    "channel.duplicate=0.25": "channel.duplicate: 0.25 does not run on arrays; allowed: 0",
    "beacons.rule=etsi-cam": "beacons.rule: etsi-cam does not run on arrays; "
    "allowed: every-cycle, every-nth",
    "channel.loss.path_loss={}": "channel.loss.path_loss: received power does not run on arrays; "
    "allowed: null",
}
EVERYTHING: Final = [text for change in NOT_COVERED for text in ("--set", change)]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make the current folder one with a scenario and its own laws, and return it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pi.py").write_text(LAW)
    (tmp_path / "own.yaml").write_text(OWN)
    return tmp_path


def summary(folder: Path) -> dict[str, Any]:
    """Return the summary that `zenvoy run` writes beside the log."""
    found: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return found


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


def test_a_scenario_that_arrays_do_not_run_is_refused_at_once(here: Path) -> None:
    run = ("run", "quickstart", *EVERYTHING, "--engine", "arrays", "--out", "o")
    refused = zenvoy(here, *run)
    assert refused == Outcome(2, "", refused.err)
    assert sorted(refused.err.splitlines()) == sorted(NOT_COVERED.values())
    assert not (here / "o").exists()
    changed = api.scenario("quickstart", channel={"medium": {"access": "csma"}})
    with pytest.raises(api.InputError) as error:
        api.run(changed, engine="arrays", out="o")
    assert str(error.value) == NOT_COVERED["channel.medium.access=csma"]
    assert not (here / "o").exists()


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            ("--set", "estimator.kind=ekf", "--set", "control.model=PBCM"),
            "estimator.kind: ekf does not run on arrays; allowed: kalman",
        ),
        (
            ("--set", "vehicle.actuator_lag_s=0.5", "--set", "control.model=SPBCM"),
            "vehicle.actuator_lag_s: 0.5 with a law that shares links does not run on arrays; "
            "allowed: null",
        ),
        (
            (
                "--set",
                "control={neighbour_state: position, model: PBCM, beacon_age_limit_ms: 200}",
                "--set",
                "channel.rules=[{latency: {distribution: fixed, mean_ms: 5000}}]",
            ),
            "channel.rules.0.latency: fixed of up to 5000 ms does not run on arrays; "
            "allowed: up to 389 ms with control.neighbour_state: position",
        ),
    ],
    ids=["estimator", "lag", "memory"],
)
def test_estimators_that_arrays_do_not_run_are_refused(
    here: Path, changes: tuple[str, ...], line: str
) -> None:
    refused = zenvoy(here, "run", "quickstart", *changes, "--engine", "arrays", "--out", "o")
    assert (refused.code, refused.out) == (2, "")
    assert refused.err.splitlines() == [line]


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        (
            "control.model=pi:BRANCHING",
            "control.model: pi:BRANCHING does not run on arrays: it raises ValueError: The truth "
            "value of an array with more than one element is ambiguous. Use a.any() or a.all();"
            " allowed: a law for floats and arrays (docs/arrays.md)",
        ),
        (
            "control.schedule=[{at_s: 1, model: 'pi:ENDING'}]",
            "control.schedule.0.model: pi:ENDING does not run on arrays: it raises Ended: for good;"
            " allowed: a law for floats and arrays (docs/arrays.md)",
        ),
    ],
    ids=["branching", "ending"],
)
def test_a_law_that_does_not_take_arrays_is_refused(here: Path, setting: str, line: str) -> None:
    refused = zenvoy(here, "run", "own.yaml", "--set", setting, "--engine", "arrays", "--out", "o")
    assert refused == Outcome(2, "", f"{line}\n")
    checked = zenvoy(here, "check", "own.yaml", "--set", setting)
    assert checked == Outcome(0, f"own: valid; 3 vehicles, 6 s\n{line}\n", "")


def test_auto_takes_arrays_if_they_run_the_scenario(here: Path) -> None:
    outcome = zenvoy(here, "run", "own.yaml", "--engine", "auto", "--out", "o")
    assert outcome.code == 0
    assert outcome.out.splitlines()[0] == "engine: arrays"
    assert summary(here / "o")["bus"] == "arrays"
    assert api.run("own.yaml", engine="auto", out="p").summary["bus"] == "arrays"


def test_auto_prints_why_it_does_not_take_arrays(here: Path) -> None:
    changes = ("--set", "channel.relay_hops=3", "--set", "channel.duplicate=0.25")
    outcome = zenvoy(here, "run", "own.yaml", *changes, "--engine", "auto", "--out", "o")
    assert outcome.code == 0
    assert outcome.out.splitlines()[:3] == [
        "engine: in-process",
        f"  {NOT_COVERED['channel.relay_hops=3']}",
        f"  {NOT_COVERED['channel.duplicate=0.25']}",
    ]
    assert summary(here / "o")["bus"] == "in-process"


def test_check_prints_why_arrays_do_not_run_a_scenario(here: Path) -> None:
    assert zenvoy(here, "check", "own.yaml").out.splitlines()[1:] == ["runs on arrays"]
    checked = zenvoy(here, "check", "own.yaml", *EVERYTHING)
    assert checked.code == 0
    assert sorted(checked.out.splitlines()[1:]) == sorted(NOT_COVERED.values())


@pytest.mark.parametrize("engine", ["arrays", "auto", "in-process"])
@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--realtime",), "clock: realtime needs processes; allowed: --engine processes"),
        (
            ("--listen", "tcp/127.0.0.1:0"),
            "--without, --listen, --router and --vehicles-per-process need processes; "
            "allowed: --engine processes",
        ),
    ],
    ids=["clock", "guests"],
)
def test_options_that_need_processes_are_refused(
    here: Path, options: tuple[str, ...], expected: str, engine: str
) -> None:
    refused = zenvoy(here, "run", "own.yaml", *options, "--engine", engine, "--out", "o")
    assert refused == Outcome(2, "", f"{expected}\n")
    assert not (here / "o").exists()


def test_the_older_option_still_works(here: Path) -> None:
    run = ("run", "own.yaml", "--duration-s", "1", "--out")
    assert zenvoy(here, *run, "a", "--bus", "in-process", "--engine", "in-process").code == 0
    assert zenvoy(here, *run, "b", "--bus", "zenoh", "--engine", "processes").code == 0
    assert [summary(here / name)["bus"] for name in "ab"] == ["in-process", "zenoh"]
    for bus, engine in (("zenoh", "arrays"), ("in-process", "auto"), ("in-process", "processes")):
        refused = zenvoy(here, *run, "c", "--bus", bus, "--engine", engine)
        expected = f"--bus {bus}: contradicts --engine {engine}; allowed: one of them\n"
        assert refused == Outcome(2, "", expected)
    assert not (here / "c").exists()


def test_the_page_has_every_key_that_arrays_do_not_run() -> None:
    root = next(folder for folder in Path(__file__).parents if (folder / "Makefile").exists())
    page = (root / "docs" / "arrays.md").read_text()
    rows = [line.split("|") for line in page.splitlines() if line.startswith("| `")]
    allowed = {cells[1].split("`")[1]: cells[2].replace("`", "").strip() for cells in rows}
    for line in NOT_COVERED.values():
        key, _, rest = line.partition(": ")
        assert allowed[key] == rest.partition("; allowed: ")[2]


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
