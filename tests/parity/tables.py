"""Tables of a figure of each vehicle, in SUMO and in Zenvoy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tests.parity.cases import Floats

PAGE: Final = Path(__file__).parents[2] / "docs" / "validation.md"


@dataclass(frozen=True, slots=True)
class Compared:
    """A figure of vehicles 2 to 8 under a law, in both simulators."""

    law: str
    sumo: Floats
    zenvoy: Floats

    @property
    def difference(self) -> Floats:
        """By how much Zenvoy's figures exceed SUMO's, relative to these."""
        return self.zenvoy / self.sumo - 1.0


def table(rows: Iterable[Compared], digits: int) -> list[str]:
    """Return the lines of a table in Markdown, with three rows for each law."""
    lines = ["| law | | 2 | 3 | 4 | 5 | 6 | 7 | 8 |", f"|---|---|{'---:|' * 7}"]
    for row in rows:
        cells = {
            "SUMO": [f"{value:.{digits}f}" for value in row.sumo],
            "Zenvoy": [f"{value:.{digits}f}" for value in row.zenvoy],
            "difference, %": [f"{100.0 * value:+.1f}" for value in row.difference],
        }
        lines += [f"| {row.law} | {name} | {' | '.join(of)} |" for name, of in cells.items()]
    return lines


def differences_from_page(lines: list[str]) -> list[str]:
    """Return the lines of a printed table that the page lacks.

    Numbers may differ by one unit of their last digit, since other processors round otherwise.
    """
    rows = cells_of_page()
    return [line for line in lines if not any(_agree(_cells(line), row) for row in rows)]


def cells_of_page() -> list[list[str]]:
    """Return the cells of each line of the page; a line outside of tables is one cell."""
    return [_cells(line) for line in PAGE.read_text(encoding="utf-8").splitlines()]


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def _agree(printed: list[str], shown: list[str]) -> bool:
    return len(printed) == len(shown) and all(map(_equal, printed, shown))


def _equal(printed: str, shown: str) -> bool:
    if printed == shown:
        return True
    try:
        off = abs(float(printed) - float(shown))
    except ValueError:
        return False
    return off < 1.5 * 10.0 ** -len(printed.partition(".")[2])
