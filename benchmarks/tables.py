"""Tables of rates that are measured in rounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Final

from rich.console import Console
from rich.table import Table

ROUNDS: Final = 3


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table; `rate` makes one short run and returns its rate in the table's unit."""

    name: str
    rate: Callable[[], float]


@dataclass(frozen=True, slots=True)
class Part:
    """A table, and a note that explains it; `ratios` adds the ratios to the first row."""

    unit: str
    rows: Sequence[Row]
    note: str = ""
    ratios: bool = False


def rates_of(parts: Sequence[Part], console: Console) -> dict[str, list[float]]:
    """Run all rows in turn, ROUNDS times; return the rates of each row by name."""
    rates: dict[str, list[float]] = {row.name: [] for part in parts for row in part.rows}
    for round_ in range(1, ROUNDS + 1):
        for part in parts:
            for row in part.rows:
                rate = row.rate()
                rates[row.name].append(rate)
                line = f"round {round_} of {ROUNDS}: {row.name}: {rate:,.1f} {part.unit}"
                console.print(line, highlight=False)
    return rates


def _cells(rates: Sequence[float]) -> tuple[str, str]:
    digits = 0 if median(rates) >= 20 else 1
    middle, low, high = (f"{rate:,.{digits}f}" for rate in (median(rates), min(rates), max(rates)))
    return middle, f"{low} to {high}"


def _headers(part: Part) -> list[str]:
    headers = ["what", f"{part.unit}, median of {ROUNDS}", "range"]
    return [*headers, "ratio to the first row"] if part.ratios else headers


def _row(part: Part, row: Row, rates: Mapping[str, Sequence[float]]) -> list[str]:
    cells = [row.name, *_cells(rates[row.name])]
    if not part.ratios:
        return cells
    pairs = zip(rates[row.name], rates[part.rows[0].name], strict=True)
    return [*cells, f"{median(one / other for one, other in pairs):.1f}"]


def table_of(part: Part, rates: Mapping[str, Sequence[float]]) -> Table:
    """Return the table of a part for the terminal."""
    table = Table(*_headers(part))
    for column in table.columns[1:]:
        column.justify = "right"
    for row in part.rows:
        table.add_row(*_row(part, row, rates))
    return table


def markdown(
    measured_on: Sequence[str], parts: Sequence[Part], rates: Mapping[str, Sequence[float]]
) -> str:
    """Return all tables as Markdown, with what they were measured on."""
    lines = [
        "# Benchmark results",
        "",
        f"Written by `python -m benchmarks`: medians of {ROUNDS} short runs, run in turn.",
        "",
        *measured_on,
        "",
    ]
    for part in parts:
        headers = _headers(part)
        lines += [_line(headers), f"|---|{'---:|' * (len(headers) - 1)}"]
        lines += [_line(_row(part, row, rates)) for row in part.rows]
        lines += ["", part.note] if part.note else [""]
    return "\n".join(lines)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
