"""The findings of a comparison: means over seeds by measure and law, and how laws differ."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.statistics import Mean, mean_of
from zenvoy.studies.comparison.laws import ComparedLaw
from zenvoy.studies.sweeps.results import Results


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A measure of a law: its mean, and the mean of its differences from the first law.

    The differences are between runs with the same seed. Each is None if no run has the measure.
    """

    measure: str
    law: ComparedLaw
    mean: Mean | None
    difference: Mean | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """The runs of all laws with the same seeds; law i is cell i + 1 of the sweep."""

    laws: tuple[ComparedLaw, ...]
    results: Results
    notes: tuple[str, ...] = ()

    @property
    def measures(self) -> tuple[str, ...]:
        """The measures that a run has."""
        rows = self.results.rows
        return tuple(
            name
            for name in self.results.measures
            if any(row.figures[name] is not None for row in rows)
        )

    def of(self, measure: str) -> tuple[Finding, ...]:
        """Return the findings for a measure, law by law."""
        values = [self._by_seed(number, measure) for number in range(1, len(self.laws) + 1)]
        return tuple(
            Finding(
                measure=measure,
                law=law,
                mean=_mean(list(own.values())),
                difference=_mean([own[seed] - values[0][seed] for seed in own if seed in values[0]])
                if number
                else None,
            )
            for number, (law, own) in enumerate(zip(self.laws, values, strict=True))
        )

    def findings(self) -> Iterator[Finding]:
        """Yield all findings, measure by measure."""
        for measure in self.measures:
            yield from self.of(measure)

    def _by_seed(self, cell: int, measure: str) -> dict[int, float]:
        """Return the values of a measure by seed, of the runs of a law that have it."""
        found = {}
        for row in self.results.rows:
            value = row.figures[measure]
            if row.cell.number == cell and value is not None:
                found[row.seed] = float(value)
        return found


def unit_of(measure: str) -> str:
    """Return the unit of a measure; "" if it has none."""
    return MEASURES[measure].unit


def _mean(values: list[float]) -> Mean | None:
    return mean_of(values) if values else None
