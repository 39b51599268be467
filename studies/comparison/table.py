"""A comparison as tables: for people with intervals as text, and as CSV with a number per cell."""

from __future__ import annotations

import math
from typing import Final

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.statistics import Mean
from zenvoy.analysis.page.digits import text
from zenvoy.analysis.page.section import Cell, Section, Sheet
from zenvoy.studies.comparison.compared import Comparison, unit_of
from zenvoy.studies.sweeps.plan import counted
from zenvoy.studies.sweeps.table import cells_of, half, titled

_INTERVAL_DIGITS: Final = 2  # significant digits of half an interval; the mean ends with the same
_MOST_DECIMALS: Final = 6

COLUMNS: Final = (
    "measure",
    "unit",
    "law",
    "seeds",
    "mean",
    "half_interval",
    "difference",
    "half_interval_of_difference",
)
"""The columns of laws.csv. Intervals have 95 % confidence; differences are from the first law."""


def section(compared: Comparison) -> Section:
    """Return the means, and the differences from the first law, with intervals as text."""
    sheets = [_means(compared)]
    if len(compared.laws) > 1:
        sheets.append(_differences(compared))
    return Section(title="Laws", sheets=tuple(sheets))


def rows(compared: Comparison) -> list[tuple[Cell, ...]]:
    """Return a row with COLUMNS for each measure and law."""
    found: list[tuple[Cell, ...]] = []
    for one in compared.findings():
        seeds = 0 if one.mean is None else one.mean.n
        figures = (*cells_of(one.mean), *cells_of(one.difference))
        found.append((one.measure, unit_of(one.measure), one.law.label, seeds, *figures))
    return found


def with_interval(mean: Mean | None, seeds: int) -> str | None:
    """Return text such as "36.70 ± 0.02", with the number of seeds if not all have a value."""
    if mean is None:
        return None
    spread = half(mean)
    some = "" if mean.n == seeds else f" ({counted(mean.n, 'seed')})"
    if not spread:  # a single seed, or all have the same value
        return text(mean.mean) + some
    decimals = _INTERVAL_DIGITS - 1 - math.floor(math.log10(spread))
    decimals = min(_MOST_DECIMALS, max(0, decimals))
    written = f"{mean.mean:.{decimals}f} ± {spread:.{decimals}f}"
    return written.replace("-", "−") + some


def _means(compared: Comparison) -> Sheet:
    return _sheet(
        compared,
        "means-of-laws",
        f"Means over {counted(len(compared.results.plan.seeds), 'seed')}",
        "± is half the 95 % confidence interval over seeds (Student's t). All laws have the same"
        " seeds.",
        first=0,
    )


def _differences(compared: Comparison) -> Sheet:
    return _sheet(
        compared,
        "differences-of-laws",
        f"Differences from {compared.laws[0].label}, seed by seed",
        "Laws differ where the interval does not contain 0.",
        first=1,
    )


def _sheet(compared: Comparison, name: str, title: str, note: str, first: int) -> Sheet:
    """Return a row per law from law `first` on, and a column per measure."""
    seeds = len(compared.results.plan.seeds)
    columns = [
        [with_interval(one.difference if first else one.mean, seeds) for one in found[first:]]
        for found in map(compared.of, compared.measures)
    ]
    titles = [titled(MEASURES[name].meaning, MEASURES[name].unit) for name in compared.measures]
    labels = [law.label for law in compared.laws[first:]]
    found = zip(labels, *columns, strict=True)
    return Sheet(name=name, title=title, columns=("law", *titles), rows=tuple(found), note=note)
