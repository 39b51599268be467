"""Time series of a whole fleet, one value for each cycle."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.braking import brakings
from zenvoy.analysis.measures.emissions import fuel_rate
from zenvoy.analysis.measures.following import ends
from zenvoy.analysis.measures.metrics import max_distance, min_distance
from zenvoy.analysis.measures.motion import speed_spread
from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Series:
    """A time series: its unit, its meaning, and a function that computes it from a run, (T,)."""

    unit: str
    meaning: str
    of: Callable[[Run], Floats]


def _gap(run: Run) -> Floats:
    return np.asarray(gaps(run.truth["position"], run.scenario.ring_length_m))


def _speed_of_end(run: Run, end: Literal[0, 1]) -> Floats:
    """Return the speed of the head (0) or of the tail (1); NaN where a run has neither."""
    found = ends(run)
    speed = run.truth["speed"]
    return np.full(len(speed), np.nan) if found is None else np.asarray(speed[:, found[end]])


SERIES: Final[Mapping[str, Series]] = MappingProxyType(
    {
        "smallest_gap_m": Series("m", "smallest gap", lambda r: np.nanmin(_gap(r), axis=1)),
        "largest_gap_m": Series("m", "largest gap", lambda r: np.nanmax(_gap(r), axis=1)),
        "min_distance_m": Series("m", "MinDistance", lambda r: min_distance(_gap(r))),
        "max_distance_m": Series("m", "MaxDistance", lambda r: max_distance(_gap(r))),
        "mean_speed_mps": Series("m/s", "mean speed", lambda r: r.truth["speed"].mean(axis=1)),
        "lowest_speed_mps": Series("m/s", "lowest speed", lambda r: r.truth["speed"].min(axis=1)),
        "speed_spread_mps": Series(
            "m/s",
            "standard deviation of speed over the vehicles",
            lambda r: speed_spread(r.truth["speed"]),
        ),
        "fuel_mg_per_s": Series(
            "mg/s",
            "petrol of the whole fleet",
            lambda r: fuel_rate(r.truth["speed"], r.truth["acceleration"]).sum(axis=1),
        ),
        "brakings": Series(
            "",
            "vehicles that begin to brake harder than 1 m/s²",
            lambda r: brakings(r.truth["acceleration"]),
        ),
        "head_speed_mps": Series("m/s", "speed of the head", lambda r: _speed_of_end(r, 0)),
        "tail_speed_mps": Series("m/s", "speed of the tail", lambda r: _speed_of_end(r, 1)),
    }
)
