"""`zenvoy calibrate` writes a table, a picture and a scenario, and refuses in one line."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.recorded_convoys import GAP_M, K, L, openacc_text, platoon


def test_the_synthetic_cars_are_found_again(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(openacc_text(platoon(40.0)))
    (tmp_path / "b.csv").write_text(openacc_text(platoon(20.0, hz=0.1)))
    done = zenvoy(tmp_path, "calibrate", "a.csv", "--law", "fm", "--hold-out", "b.csv",
                  "--bound", "k_c=0:0.01")  # fmt: skip
    assert (done.code, done.err) == (0, "")
    with (tmp_path / "a-fm" / "calibration.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["car"] for row in rows] == ["CAR_B", "CAR_C", "CAR_D"]
    for row in rows:
        assert float(row["k_d"]) == pytest.approx(K, rel=0.2)
        assert float(row["k_v"]) == pytest.approx(L, rel=0.2)
        assert float(row["desired_gap_m"]) == pytest.approx(GAP_M + 5.0, abs=0.5)
        assert float(row["error of gap, m"]) < 0.1
        assert float(row["held out: error of gap, m"]) < 0.1
    names = {path.name for path in (tmp_path / "a-fm").iterdir()}
    assert {"calibration.html", "calibration.png", "scenario.yaml", "recorded.csv"} <= names
    checked = zenvoy(tmp_path, "check", "a-fm/scenario.yaml", "--strict")
    assert (checked.code, checked.err) == (0, "")
    again = zenvoy(tmp_path, "calibrate", "a-fm", "--law", "acc", "--cars", "CAR_B,CAR_C",
                   "--out", "acc")  # fmt: skip
    assert again.code == 0


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--law", "bcm"), "--law: BCM uses what others report; allowed: a law that looks ahead by "
                           "its own radar only"),
        (("--law", "fm", "--bound", "k_d=2:1"), "--bound k_d=2:1: is not of the form "
                                                "NAME=LOW:HIGH, with LOW below HIGH"),
        (("--law", "fm", "--bound", "k_d"), "--bound k_d: is not of the form NAME=LOW:HIGH, with "
                                            "LOW below HIGH"),
        (("--law", "fm", "--hold-out", "c.csv"), "'c.csv' cannot be read: No such file or "
                                                 "directory"),
    ],
)  # fmt: skip
def test_wrong_options_are_one_line(tmp_path: Path, options: tuple[str, ...], line: str) -> None:
    (tmp_path / "a.csv").write_text(openacc_text(platoon(10.0)))
    done = zenvoy(tmp_path, "calibrate", "a.csv", *options)
    assert (done.code, done.err) == (2, f"{line}\n")


def test_a_law_that_fails_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(openacc_text(platoon(10.0)))
    (tmp_path / "bad.py").write_text(
        "from dataclasses import dataclass\nfrom zenvoy.laws import Law\n\n"
        "@dataclass(frozen=True)\nclass P:\n    gain: float = 1.0\n\n"
        "def f(seen, own):\n    return seen.nothing\n\n"
        'BAD = Law(name="Bad", acceleration=f, parameters=P)\n'
    )
    done = zenvoy(tmp_path, "calibrate", "a.csv", "--law", "bad.py:BAD")
    assert done.code == 1
    assert done.err.startswith("law Bad raised AttributeError")
    assert len(done.err.splitlines()) == 1
