"""Figures of traffic on a ring over a span of time, from the time series of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.measures.emissions import PETROL_G_PER_L

Floats = NDArray[np.float64]

SERIES_NEEDED: Final = ("mean_speed_mps", "speed_spread_mps", "fuel_mg_per_s", "brakings")


class Span(NamedTuple):
    """A span of time, s."""

    from_s: float
    until_s: float


class Ring(NamedTuple):
    """The number of vehicles on a ring, and its length (m)."""

    vehicles: int
    length_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Flow:
    """Traffic over a span of time.

    std_mps is the standard deviation of all speeds of all vehicles. flow_per_h is the number of
    vehicles that pass a point in an hour. brakings_per_km is per vehicle. The figures per distance
    are NaN if nobody moves.
    """

    std_mps: float
    mean_mps: float
    flow_per_h: float
    brakings_per_km: float
    fuel_l_per_100km: float


class Figure(NamedTuple):
    """A figure of a flow, its title and its unit."""

    of: Callable[[Flow], float]
    title: str
    unit: str


FIGURES: Final = (
    Figure(lambda flow: flow.std_mps, "standard deviation of speed", "m/s"),
    Figure(lambda flow: flow.brakings_per_km, "brakings per vehicle and km", "1/km"),
    Figure(lambda flow: flow.flow_per_h, "throughput", "1/h"),
    Figure(lambda flow: flow.fuel_l_per_100km, "fuel", "l/100 km"),
    Figure(lambda flow: flow.mean_mps, "mean speed", "m/s"),
)


def flow_in(series: Mapping[str, Floats], span: Span, ring: Ring) -> Flow:
    """Return the figures of a span; `series` has `time_s` and SERIES_NEEDED, (T,) each."""
    rows = (series["time_s"] >= span.from_s) & (series["time_s"] < span.until_s)
    mean, spread, fuel, brakings = (series[name][rows] for name in SERIES_NEEDED)
    v = float(mean.mean())
    driven_m = v * ring.vehicles * (span.until_s - span.from_s)
    litres = float(fuel.mean()) * (span.until_s - span.from_s) * 1e-3 / PETROL_G_PER_L
    return Flow(
        std_mps=float(np.sqrt(np.mean(spread * spread) + np.var(mean))),
        mean_mps=v,
        flow_per_h=3600.0 * v * ring.vehicles / ring.length_m,
        brakings_per_km=_per(float(brakings.sum()), driven_m * 1e-3),
        fuel_l_per_100km=_per(litres, driven_m * 1e-5),
    )


def _per(value: float, distance: float) -> float:
    return value / distance if distance > 0.0 else float("nan")
