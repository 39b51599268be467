"""`zenvoy analyze --recorded` puts the cars of an import next to the vehicles of a run."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import zenvoy
from tests.recorded_convoys import CARS, openacc_text, platoon


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "a.csv").write_text(openacc_text(platoon(20.0)))
    assert zenvoy(folder, "import", "openacc", "a.csv").code == 0
    gains = ("--set", "control.gains={k_d: 0.1, k_v: 0.4, k_c: 0}", "--engine", "in-process")
    gap = ("--set", "control.desired_gap_m=25", "--set", "control.system_delay_ms=0")
    assert zenvoy(folder, "run", "a/scenario.yaml", *gains, *gap, "--out", "fm").code == 0
    assert zenvoy(folder, "run", "quickstart", "--duration-s", "2", "--engine", "in-process",
                  "--out", "other").code == 0  # fmt: skip
    return folder


def test_the_law_of_the_synthetic_cars_drives_as_they_do(runs: Path) -> None:
    done = zenvoy(runs, "analyze", "fm/run.mcap", "--recorded", "a", "--out", "report")
    assert (done.code, done.err) == (0, "")
    assert "Recorded convoy" in done.out
    with (runs / "report" / "recorded.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["car"] for row in rows] == list(CARS)
    swing = platoon(20.0).speed.std(axis=0)
    assert [float(row["swing, recorded, m/s"]) for row in rows] == pytest.approx(swing, abs=1e-4)
    growth = [float(row["growth, recorded"]) for row in rows[1:]]
    assert growth == pytest.approx(swing[1:] / swing[:-1], abs=1e-4)
    assert float(rows[0]["difference of speed, m/s"]) < 1e-3
    differences = [float(row["difference of gap, m"]) for row in rows[1:]]
    assert np.max(differences) < 0.1
    names = {path.name for path in (runs / "report").iterdir()}
    assert {"recorded-speeds.png", "recorded-swing.svg", "report.html"} <= names


@pytest.mark.parametrize(
    ("log", "recorded", "line"),
    [
        ("other", "a", "--recorded a: 4 cars, but the run has 20 vehicles"),
        ("fm", "no", "'no' cannot be read: No such file or directory"),
        ("fm", "a/leader.csv", "neither a file of OpenACC nor what zenvoy import has written; "
                               "allowed: the folder that zenvoy import table makes of it"
                               "  (a/leader.csv)"),
    ],
)  # fmt: skip
def test_another_recording_is_refused_in_a_line(
    runs: Path, log: str, recorded: str, line: str
) -> None:
    done = zenvoy(runs, "analyze", f"{log}/run.mcap", "--recorded", recorded)
    assert (done.code, done.err) == (2, f"{line}\n")
