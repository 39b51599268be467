"""The ring of Stern et al. (2018): a wave comes among 22 drivers, and one controlled car ends it.

The built-in scenarios `ring/follower-stopper` and `ring/pi` say from when on the car is controlled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.measures.statistics import mean_of
from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.scenarios import load
from zenvoy.studies.mixed.flow import (
    FIGURES,
    SERIES_NEEDED,
    Figure,
    Flow,
    Ring,
    Span,
    flow_in,
)
from zenvoy.studies.sweeps.sweep import Made
from zenvoy.studies.sweeps.table import cells_of

Floats = NDArray[np.float64]

HUMANS: Final = "ring/humans"
CONTROLLED: Final = {
    "FollowerStopper": "ring/follower-stopper",
    "PI": "ring/pi",
    "LCC": "ring/lcc",
}
"""The scenario of each law of the controlled car."""

_IN_THE_FIELD: Final = ("FollowerStopper", "PI")
"""The laws of the experiments."""

NOBODY: Final = "no control"
CAR: Final = "car"
_SPAN_S: Final = 50.0

PUBLISHED: Final[Mapping[str, int]] = {
    "standard deviation of speed": -81,
    "brakings per vehicle and km": -99,
    "throughput": 14,
    "fuel": -42,
}
"""The largest changes in the three experiments of Stern et al. (2018), %."""


class Spans(NamedTuple):
    """The last time before a car is controlled, and the last time of the run."""

    before: Span
    after: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Driven:
    """The runs of one variant, by seed: time series, and the flow before and after."""

    car: str
    series: tuple[Mapping[str, Floats], ...]
    before: tuple[Flow, ...]
    after: tuple[Flow, ...]


def study(seeds: int, duration_s: float | None) -> dict[str, Any]:
    """Return the study for a sweep: the ring without control, and with each controlled car."""
    variants: dict[str, dict[str, Any]] = {NOBODY: {}} | {
        car: {"control.schedule": _schedule(name)} for car, name in CONTROLLED.items()
    }
    keys = {
        "scenario": HUMANS,
        "axes": {CAR: {"variants": variants}},
        "seeds": seeds,
        "measures": ["collisions"],
        "series": list(SERIES_NEEDED),
    }
    return keys if duration_s is None else {**keys, "duration_s": duration_s}


def _schedule(name: str) -> list[dict[str, Any]]:
    control = load(name).scenario.control.model_dump(mode="json", exclude_defaults=True)
    schedule: list[dict[str, Any]] = control["schedule"]
    return schedule


def spans(duration_s: float) -> Spans:
    """Return the spans that are compared, in runs of this duration."""
    start_s = min(entry["at_s"] for name in CONTROLLED.values() for entry in _schedule(name))
    return Spans(Span(start_s - _SPAN_S, start_s), Span(duration_s - _SPAN_S, duration_s))


def driven(made: Made, compared: Spans) -> tuple[Driven, ...]:
    """Return the runs of the study by variant; runs that failed are left out."""
    fleet, (before, after) = load(HUMANS).scenario.fleet, compared
    ring = Ring(fleet.size, fleet.size * fleet.gap_m)
    found: dict[str, list[Mapping[str, Floats]]] = {}
    for row in made.results.rows:
        stored = made.store.series(row.key, SERIES_NEEDED)
        if stored is not None:
            found.setdefault(row.cell.point[CAR], []).append(stored)
    return tuple(
        Driven(
            car=car,
            series=tuple(series),
            before=tuple(flow_in(one, before, ring) for one in series),
            after=tuple(flow_in(one, after, ring) for one in series),
        )
        for car, series in found.items()
    )


def sheet(runs: Sequence[Driven]) -> Sheet:
    """Return a row for each figure and variant: before and after the control, and the change."""
    return Sheet(
        name="ring",
        title="The ring before and after one of 22 cars is controlled",
        columns=(
            "figure",
            "unit",
            "controlled car",
            "seeds",
            "before",
            "± 95 % before",
            "after",
            "± 95 % after",
            "change, %",
            "± 95 %, %",
            "published, %",
        ),
        rows=tuple(_row(figure, one) for figure in FIGURES for one in runs),
        note="The change is that of each seed. Published: the largest change in three experiments.",
    )


def _row(figure: Figure, one: Driven) -> tuple[Cell, ...]:
    before, after = ([figure.of(flow) for flow in flows] for flows in (one.before, one.after))
    changes = [100.0 * (b - a) / a for a, b in zip(before, after, strict=True) if a]
    means = [mean_of(before), mean_of(after), mean_of(changes) if changes else None]
    published = PUBLISHED.get(figure.title) if one.car in _IN_THE_FIELD else None
    cells = [cell for mean in means for cell in cells_of(mean)]
    return (figure.title, figure.unit, one.car, len(before), *cells, published)
