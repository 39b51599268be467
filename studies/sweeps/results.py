"""The results of a sweep: a row for each cell and seed, and the means of each cell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from zenvoy.analysis.measures.figures import MEASURES, figures
from zenvoy.analysis.measures.statistics import Mean, mean_of
from zenvoy.studies.sweeps.plan import Plan, PlannedCell
from zenvoy.studies.sweeps.store import Store

_UNITS: Final = {
    "mps2": "m/s²",
    "mps": "m/s",
    "mbps": "Mbit/s",
    "ghz": "GHz",
    "dbm": "dBm",
    "db": "dB",
    "ms": "ms",
    "m": "m",
    "s": "s",
}
_GAINS: Final = {"k_d": "s⁻²", "k_v": "s⁻¹", "k_c": "s⁻¹"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A run: its cell and seed, its figures by name (None if it has none), or why it failed."""

    cell: PlannedCell
    seed: int
    key: str
    figures: Mapping[str, float | None]
    failure: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """All rows of a sweep in the order of its plan, and the measures that they show."""

    plan: Plan
    rows: tuple[Row, ...]
    measures: tuple[str, ...]

    @property
    def failed(self) -> tuple[Row, ...]:
        """The runs that failed."""
        return tuple(row for row in self.rows if row.failure is not None)

    def differs(self, measure: str) -> bool:
        """Return whether a measure differs between runs that have it."""
        values = {row.figures[measure] for row in self.rows}
        return len(values - {None}) > 1

    def means(self, measure: str) -> dict[int, Mean]:
        """Return the mean of a measure over the seeds of each cell, by number of cell."""
        values: dict[int, list[float]] = {}
        for row in self.rows:
            value = row.figures.get(measure)
            if value is not None:
                values.setdefault(row.cell.number, []).append(value)
        return {number: mean_of(of_cell) for number, of_cell in values.items()}


def results_of(plan: Plan, store: Store, failures: Mapping[str, str]) -> Results:
    """Return the stored results of a plan; `failures` has the reasons for missing runs, by key."""
    rows = []
    for cell in plan.cells:
        for seed, key in zip(plan.seeds, cell.keys, strict=True):
            summary = store.summary(key)
            failure = None if summary is not None else failures.get(key, "was not run")
            found = figures(summary or {})
            rows.append(Row(cell=cell, seed=seed, key=key, figures=found, failure=failure))
    return Results(plan=plan, rows=tuple(rows), measures=_shown(plan, rows))


def _shown(plan: Plan, rows: Sequence[Row]) -> tuple[str, ...]:
    """Return the measures that the study names, or else all that need no log and that a run has."""
    if plan.study.measures is not None:
        return plan.study.measures
    known = (name for name, measure in MEASURES.items() if not measure.needs_log)
    return tuple(n for n in known if any(row.figures[n] is not None for row in rows))


def unit_of_axis(key: str) -> str:
    """Return the unit at the end of a setting's name; "" if there is none."""
    last = key.rpartition(".")[2]
    return _GAINS.get(last) or _UNITS.get(last.rpartition("_")[2] if "_" in last else "", "")
