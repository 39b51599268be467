"""The tables of docs/mixed-traffic.md have the figures of the runs, rounded."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Final

import pytest

DOCS: Final = Path(__file__).parents[3] / "docs"
PAGE: Final = (DOCS / "mixed-traffic.md").read_text()
with (DOCS / "mixed-traffic" / "ring.csv").open() as file:
    FIGURES: Final = {(row["figure"], row["controlled car"]): row for row in csv.DictReader(file)}


def table(head: str) -> list[dict[str, str]]:
    """Return the rows of the table whose head begins with a word, by column."""
    lines = PAGE[PAGE.index(f"| {head} |") :].partition("\n\n")[0].splitlines()
    columns, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def assert_rounded(shown: str, mean: str, half: str) -> None:
    """Check text such as "3.16 ± 0.60" or "−97 ± 1 %" against two numbers with all digits."""
    numbers = re.fullmatch(r"([+−]?[\d.]+) ± ([\d.]+)(?: %)?", shown)
    assert numbers is not None, shown
    for text, value in zip(numbers.groups(), (mean, half), strict=True):
        digits = len(text.partition(".")[2])
        assert float(text.replace("−", "-")) == round(float(value), digits), shown


CARS: Final = ("no control", "FollowerStopper", "PI", "LCC")


@pytest.mark.parametrize("row", table("figure"), ids=lambda row: row["figure"])
def test_figures_before_and_after(row: dict[str, str]) -> None:
    figure, _, unit = row["figure"].rpartition(", ")
    for car in CARS:
        found = FIGURES[figure, car]
        assert found["unit"] == unit
        assert_rounded(row["before"], found["before"], found["± 95 % before"])
        assert_rounded(row[car], found["after"], found["± 95 % after"])


@pytest.mark.parametrize("row", table("change"), ids=lambda row: row["change"])
def test_changes(row: dict[str, str]) -> None:
    for car in CARS:
        found = FIGURES[row["change"], car]
        assert_rounded(row[car], found["change, %"], found["± 95 %, %"])
    published = FIGURES[row["change"], "PI"]["published, %"]
    assert float(row["published"].rstrip(" %").replace("−", "-")) == float(published)
