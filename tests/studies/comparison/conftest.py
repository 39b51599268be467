"""A comparison that several tests share."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, Final

import pyarrow.parquet
import pytest

from tests.conftest import Outcome, zenvoy
from tests.idm import IDM

SCENARIO: Final = """
extends: quickstart
fleet: {size: 6}
duration_s: 4
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 3}]
control: {model: "mylaws:smith", parameters: {headway_s: 1.6}}
"""
LAWS: Final = ("FM", "PBCM", "mylaws:smith", "mylaws:smith:{headway_s: 0.9}")


def write_scenario(folder: Path) -> None:
    """Write a scenario s.yaml with a law of its own beside it."""
    (folder / "s.yaml").write_text(SCENARIO)
    (folder / "mylaws.py").write_text(IDM)


def compare(folder: Path, *arguments: str, laws: tuple[str, ...] = LAWS) -> Outcome:
    """Compare laws in s.yaml with results in `out`."""
    options = [part for law in laws for part in ("--law", law)]
    return zenvoy(folder, "compare-laws", "s.yaml", *options, "--out", "out", *arguments)


def table(folder: Path) -> list[dict[str, Any]]:
    """Return the runs of a comparison."""
    path = folder / "out" / "table.parquet"
    rows: list[dict[str, Any]] = pyarrow.parquet.read_table(path).to_pylist()
    return rows


def findings(folder: Path) -> dict[tuple[str, str], dict[str, str]]:
    """Return the rows of laws.csv by measure and law."""
    with (folder / "out" / "laws.csv").open() as file:
        return {(row["measure"], row["law"]): row for row in csv.DictReader(file)}


@pytest.fixture(scope="module")
def compared(folder: Path) -> Path:
    """Return a folder with a comparison of LAWS over four seeds in `out`."""
    write_scenario(folder)
    outcome = compare(folder, "--seeds", "4")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    assert outcome.out.startswith("4 cells × 4 seeds: 16 runs, 16 to do\n")
    return folder
