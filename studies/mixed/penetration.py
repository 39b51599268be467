"""How a growing share of equipped vehicles changes the traffic of human drivers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from zenvoy.analysis.measures.statistics import Mean, mean_of
from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.analysis.theory.mixed_ring import growth_per_s
from zenvoy.scenarios import load
from zenvoy.studies.mixed.flow import SERIES_NEEDED, Flow, Ring, Span, flow_in
from zenvoy.studies.sweeps.results import Row
from zenvoy.studies.sweeps.sweep import Made
from zenvoy.studies.sweeps.table import cells_of

LAWS: Final = ("BCM", "PBCM", "LCC")
SCENARIOS: Final = {"ring/equipped": "22 cars on 260 m", "mixed/drivers": "40 cars on 1500 m"}
"""The scenarios, and what they are in a picture."""

SHARES: Final = (0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1)
_LAW: Final = "fleet.groups.0.model"
_SHARE: Final = "fleet.groups.0.share"
_HUMANS: Final = "fleet.groups.1.beacons"
_SPAN_S: Final = 100.0


class Line(NamedTuple):
    """A line of a picture: scenario, law of the equipped cars, whether humans send beacons."""

    scenario: str
    law: str
    beacons: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """A share of equipped cars, and the means over seeds at the end of the runs.

    growth_per_s is the growth rate of the fastest wave by linear theory; None where the drivers
    send no beacons. std_mps is the standard deviation of all speeds, flow_per_h the throughput,
    collisions their number over the whole run.
    """

    share: float
    growth_per_s: Mean | None
    std_mps: Mean
    flow_per_h: Mean
    collisions: Mean


def study(
    scenario: str, seeds: int, duration_s: float | None, shares: Sequence[float] = SHARES
) -> dict[str, Any]:
    """Return the study of a scenario for a sweep, over laws, beacons of humans, and shares."""
    keys = {
        "scenario": scenario,
        "axes": {_LAW: list(LAWS), _HUMANS: [True, False], _SHARE: list(shares)},
        "seeds": seeds,
        "measures": ["collisions"],
        "series": list(SERIES_NEEDED),
    }
    return keys if duration_s is None else {**keys, "duration_s": duration_s}


def lines(scenario: str, made: Made, duration_s: float) -> dict[Line, list[Point]]:
    """Return the points of each line, in order of share; runs that failed are left out."""
    fleet = load(scenario).scenario.fleet
    ring = Ring(fleet.size, fleet.size * fleet.gap_m)
    span = Span(max(0.0, duration_s - _SPAN_S), duration_s)
    found: dict[tuple[Line, float], list[_Outcome]] = {}
    for row in made.results.rows:
        stored = made.store.series(row.key, SERIES_NEEDED)
        if stored is not None:
            point = row.cell.point
            key = (Line(scenario, point[_LAW], point[_HUMANS]), float(point[_SHARE]))
            flow, collisions = flow_in(stored, span, ring), float(row.figures["collisions"] or 0)
            growth = _growth(made, row) if point[_HUMANS] else None
            found.setdefault(key, []).append(_Outcome(flow, collisions, growth))
    points: dict[Line, list[Point]] = {}
    for (line, share), runs in found.items():
        points.setdefault(line, []).append(_point(share, runs))
    return points


class _Outcome(NamedTuple):
    flow: Flow
    collisions: float
    growth_per_s: float | None


def _growth(made: Made, row: Row) -> float:
    scenario = made.results.plan.cell(row.cell, row.seed).load().scenario
    return round(growth_per_s(scenario), 9)  # what is beyond differs between equal rings


def _point(share: float, runs: Sequence[_Outcome]) -> Point:
    growth = [run.growth_per_s for run in runs if run.growth_per_s is not None]
    return Point(
        share=share,
        growth_per_s=mean_of(growth) if growth else None,
        std_mps=mean_of([run.flow.std_mps for run in runs]),
        flow_per_h=mean_of([run.flow.flow_per_h for run in runs]),
        collisions=mean_of([run.collisions for run in runs]),
    )


def sheet(points: Mapping[Line, Sequence[Point]]) -> Sheet:
    """Return a row for each line and share."""
    return Sheet(
        name="penetration",
        title="Traffic by the share of equipped cars",
        columns=(
            "scenario",
            "law",
            "humans send beacons",
            "share, %",
            "seeds",
            "growth of waves, 1/s",
            "± 95 %, 1/s",
            "standard deviation of speed, m/s",
            "± 95 %, m/s",
            "throughput, 1/h",
            "± 95 %, 1/h",
            "collisions",
            "± 95 %",
        ),
        rows=tuple(_rows(points)),
    )


def _rows(points: Mapping[Line, Sequence[Point]]) -> Iterator[tuple[Cell, ...]]:
    for line, of_line in points.items():
        for one in of_line:
            means = (one.growth_per_s, one.std_mps, one.flow_per_h, one.collisions)
            yield (
                line.scenario,
                line.law,
                "yes" if line.beacons else "no",
                100.0 * one.share,
                one.std_mps.n,
                *(cell for mean in means for cell in cells_of(mean)),
            )
