"""The errors of the filter have the covariance that it reports."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.vehicles.reading_errors import gap_error, speed_error
from zenvoy.vehicles.estimator import Filter

Floats = NDArray[np.float64]

RUNS: Final = 1_000


def chi_square(share: float, degrees: int) -> float:
    """Return the quantile, to a relative 1e-5 at so many degrees (Wilson and Hilferty 1931)."""
    z, spread = NormalDist().inv_cdf(share), 2.0 / (9.0 * degrees)
    return float(degrees * (1.0 - spread + z * math.sqrt(spread)) ** 3)


def assert_consistent(nees: Floats, size: int) -> None:
    """Check NEES, one value per independent run, against the chi-square law of their sum."""
    degrees = size * len(nees)
    low, high = chi_square(0.025, degrees), chi_square(0.975, degrees)
    assert low / len(nees) < nees.mean() < high / len(nees)


def nees(*, steps: int, size: int, seed: int, loss: float = 0.0, share: float = 0.1) -> Floats:
    """Return (x - x̂)ᵀ P⁻¹ (x - x̂) of RUNS independent runs, each after `steps` periods."""
    random = np.random.default_rng(seed)
    period_s, acceleration_std = 0.1, 0.5
    variances = (gap_error().variance(37.5), speed_error().variance(30.0))[-size:]
    bounds = np.array([37.5, 30.0])[-size:] * share
    values = np.empty(RUNS)
    for run in range(RUNS):
        link = Filter(period_s, acceleration_std)
        p, v = 37.5, 0.0
        commanded = random.uniform(-1.0, 1.0, steps)
        acts = commanded + random.normal(0.0, acceleration_std, steps)
        errors = random.uniform(-1.0, 1.0, (steps + 1, size)) * bounds
        received = random.random(steps) >= loss
        received[-1] = True
        inputs: list[float] = []
        link.step((), tuple((np.array([p, v])[-size:] + errors[0]).tolist()), variances)
        for k in range(steps):
            p += period_s * v + period_s**2 / 2 * acts[k]
            v += period_s * acts[k]
            inputs.append(float(commanded[k]))
            if received[k]:
                z = np.array([p, v])[-size:] + errors[k + 1]
                link.step(inputs, tuple(z.tolist()), variances)
                inputs = []
        wrong = np.array([p, v])[-size:] - link.x
        values[run] = wrong @ np.linalg.inv(link.P) @ wrong
    return values


@pytest.mark.parametrize("size", [1, 2])
@pytest.mark.parametrize(("steps", "loss"), [(1, 0.0), (10, 0.0), (150, 0.0), (60, 0.3)])
def test_the_error_agrees_with_the_covariance(size: int, steps: int, loss: float) -> None:
    assert_consistent(nees(steps=steps, size=size, seed=11 + steps, loss=loss), size)


def test_inconsistency_is_noticed() -> None:
    with pytest.raises(AssertionError):
        assert_consistent(nees(steps=10, size=2, seed=21, share=0.11), 2)
