"""`zenvoy import` makes a scenario that starts as recorded, and whose leader drives as recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Outcome, zenvoy
from tests.recorded_convoys import LENGTH_M, Platoon, long_text, openacc_text, platoon
from zenvoy.analysis.log.load import load as load_log


@pytest.fixture(scope="module")
def found() -> Platoon:
    return platoon(20.0)


def imported(folder: Path, found: Platoon) -> Outcome:
    (folder / "run_1.csv").write_text(openacc_text(found))
    return zenvoy(folder, "import", "openacc", "run_1.csv")


def test_the_output_says_what_was_read_and_written(tmp_path: Path, found: Platoon) -> None:
    outcome = imported(tmp_path, found)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.splitlines() == [
        "cars: LEAD_CAR, CAR_B, CAR_C, CAR_D",
        "cars left out: none",
        "from: 780 s, of 780 s",
        "to: 800 s, of 800 s",
        "values bridged: 0",
        "run_1/leader.csv",
        "run_1/recorded.csv",
        "run_1/scenario.yaml",
    ]


@pytest.mark.parametrize("engine", ["processes", "arrays"])
def test_a_run_starts_and_is_led_as_recorded(tmp_path: Path, found: Platoon, engine: str) -> None:
    imported(tmp_path, found)
    outcome = zenvoy(tmp_path, "run", "run_1/scenario.yaml", "--engine", engine, "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")
    true = load_log(tmp_path / "out" / "run.mcap").truth
    np.testing.assert_allclose(true["speed"][:, 0], found.speed[:, 0], atol=1e-3)
    np.testing.assert_allclose(true["speed"][0], found.speed[0], atol=1e-3)
    gaps = -np.diff(true["position"][0]) - LENGTH_M
    np.testing.assert_allclose(gaps, found.gap[0, 1:], atol=1e-3)


def test_another_law_may_drive_the_followers(tmp_path: Path, found: Platoon) -> None:
    imported(tmp_path, found)
    law = ("--set", "control.model=PBCM", "--engine", "in-process")
    outcome = zenvoy(tmp_path, "run", "run_1/scenario.yaml", *law, "--out", "out")
    assert (outcome.code, outcome.err) == (0, "")


def test_a_table_gives_the_same_scenario(tmp_path: Path, found: Platoon) -> None:
    imported(tmp_path, found)
    (tmp_path / "t.csv").write_text(long_text(found))
    columns = (
        "--time",
        "time",
        "--vehicle",
        "id",
        "--position",
        "x",
        "--speed",
        "v",
        "--unit",
        "m/s",
    )
    zenvoy(tmp_path, "import", "table", "t.csv", *columns, "--out", "again")
    texts = [
        (tmp_path / folder / "scenario.yaml").read_text().splitlines()[1:]
        for folder in ("run_1", "again")
    ]
    assert texts[0] == texts[1]
