"""Figures of traffic agree with those computed from all speeds and accelerations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from zenvoy.analysis.measures.braking import brakings
from zenvoy.analysis.measures.emissions import consumption, fuel_rate
from zenvoy.studies.mixed.flow import Ring, Span, flow_in

Array = NDArray[Any]

RING = Ring(4, 100.0)


def series_of(speed: Array, acceleration: Array) -> dict[str, Array]:
    return {
        "time_s": 0.1 * np.arange(len(speed)),
        "mean_speed_mps": speed.mean(axis=1),
        "speed_spread_mps": speed.std(axis=1),
        "fuel_mg_per_s": fuel_rate(speed, acceleration).sum(axis=1),
        "brakings": brakings(acceleration),
    }


def test_figures_are_those_of_all_speeds_in_the_span() -> None:
    draws = np.random.default_rng(1)
    speed = draws.uniform(0.0, 12.0, (600, 4))
    acceleration = draws.uniform(-2.0, 2.0, (600, 4))
    flow = flow_in(series_of(speed, acceleration), Span(20.0, 50.0), RING)
    rows = slice(200, 500)
    assert flow.std_mps == pytest.approx(speed[rows].std())
    assert flow.mean_mps == pytest.approx(speed[rows].mean())
    assert flow.flow_per_h == pytest.approx(speed[rows].mean() * 4 / 100.0 * 3600.0)
    used = consumption(speed[rows], acceleration[rows])
    assert used is not None
    assert flow.fuel_l_per_100km == pytest.approx(used.fuel_l_per_100km)
    driven_km = speed[rows].sum() * 0.1 * 1e-3
    assert flow.brakings_per_km == pytest.approx(brakings(acceleration)[rows].sum() / driven_km)


def test_a_braking_counts_once_however_long_it_is() -> None:
    acceleration = np.array([[0.0, -1.5], [-1.2, -1.5], [-1.2, 0.0], [-0.9, -1.1], [-1.1, -1.1]])
    assert brakings(acceleration).tolist() == [1.0, 1.0, 0.0, 1.0, 1.0]


def test_nobody_moves() -> None:
    still = np.zeros((100, 4))
    flow = flow_in(series_of(still, still), Span(0.0, 10.0), RING)
    assert (flow.std_mps, flow.mean_mps, flow.flow_per_h) == (0.0, 0.0, 0.0)
    assert np.isnan([flow.brakings_per_km, flow.fuel_l_per_100km]).all()
