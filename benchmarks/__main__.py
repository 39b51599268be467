"""`python -m benchmarks`: prints how fast things are here, and writes it to results.md.

The rows are run in turn, ROUNDS times, so that a load that comes and goes meets them all.
"""

import signal
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median

from rich.console import Console
from rich.table import Table

from benchmarks.bare_zenoh import Sizes, bare_barrier
from benchmarks.convoy import convoy_rate
from benchmarks.facts import facts
from benchmarks.helics_federates import helics_steps

ROUNDS = 3
RESULTS = Path(__file__).with_name("results.md")
PACKAGES = ("eclipse-zenoh", "helics")


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the table; `rate` makes one short run and returns cycles (or steps) per second."""

    name: str
    rate: Callable[[], float]


def _bare(vehicles: int, cycles: int) -> Row:
    rate = partial(bare_barrier, vehicles, cycles, Sizes.of_fleet(vehicles))
    return Row(f"bare Zenoh barrier, {vehicles} vehicles", rate)


def _overlapped(vehicles: int, cycles: int) -> Row:
    rate = partial(bare_barrier, vehicles, cycles, Sizes.of_fleet(vehicles), lookahead=1)
    return Row(f"bare Zenoh barrier, overlapped, {vehicles} vehicles", rate)


def _convoy(vehicles: int, cycles: int) -> Row:
    rate = partial(convoy_rate, vehicles, cycles, "zenoh")
    return Row(f"Zenvoy, {vehicles} vehicle processes", rate)


ROWS: list[Row] = [
    _convoy(10, 800),
    _convoy(40, 300),
    _convoy(100, 100),
    Row("Zenvoy, 40 vehicles in one process", partial(convoy_rate, 40, 300, "in-process")),
    _bare(10, 800),
    _bare(40, 300),
    _bare(100, 100),
    _overlapped(40, 300),
    Row("HELICS (zmq), 40 federates", partial(helics_steps, 40, 300, "zmq")),
    Row("HELICS (ipc), 40 federates", partial(helics_steps, 40, 300, "ipc")),
]


def main() -> None:
    # as an exception, so that processes and socket folders are cleared up on a polite kill too
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    console = Console()
    measured_on = facts(PACKAGES)
    rates: dict[str, list[float]] = {row.name: [] for row in ROWS}
    for round_ in range(1, ROUNDS + 1):
        for row in ROWS:
            rate = row.rate()
            rates[row.name].append(rate)
            console.print(f"round {round_} of {ROUNDS}: {row.name}: {rate:,.0f}/s", highlight=False)
    console.print(_table(rates))
    RESULTS.write_text(_markdown(measured_on, rates), encoding="utf-8")


def _cells(rates: Sequence[float]) -> tuple[str, str]:
    return f"{median(rates):,.0f}", f"{min(rates):,.0f} to {max(rates):,.0f}"


def _table(rates: Mapping[str, Sequence[float]]) -> Table:
    table = Table("what", "cycles/s, median", "range")
    for column in table.columns[1:]:
        column.justify = "right"
    for name, values in rates.items():
        table.add_row(name, *_cells(values))
    return table


def _markdown(measured_on: Sequence[str], rates: Mapping[str, Sequence[float]]) -> str:
    lines = [
        "# Benchmark results",
        "",
        f"Written by `python -m benchmarks`: medians of {ROUNDS} short runs, run in turn.",
        "",
        *measured_on,
        "",
        f"| what | cycles/s, median of {ROUNDS} | range |",
        "|---|---:|---:|",
        *(f"| {name} | {' | '.join(_cells(values))} |" for name, values in rates.items()),
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
