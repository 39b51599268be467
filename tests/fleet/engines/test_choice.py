"""A run has the engine that it asks for, or one that fits, or is refused in a line."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

import zenvoy as api
from tests.conftest import Outcome, zenvoy
from tests.fleet.engines.conftest import summary

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
