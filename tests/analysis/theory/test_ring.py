"""Theory of the ring agrees with closed forms, and with eigenvalues of the whole system."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.analysis.theory.linear_cases import COUPLINGS, GAINS, MBCM3, PAPER
from zenvoy.analysis.theory.chain import Member, is_stable
from zenvoy.analysis.theory.laws import BCM, FM, Coupling, mbcm
from zenvoy.analysis.theory.ring import (
    eigenvalue,
    long_wave_speed,
    metres_per_second,
    modes,
    roots,
    slowest_mode,
    wave_speeds,
)
from zenvoy.laws.library.mbcm import weights_of
from zenvoy.scenarios import Gains

Floats = NDArray[np.float64]


def test_eigenvalues_have_their_closed_form() -> None:
    theta = np.linspace(0.0, np.pi, 9)
    np.testing.assert_allclose(eigenvalue(BCM, theta), 2.0 * (1.0 - np.cos(theta)), atol=1e-15)
    np.testing.assert_allclose(eigenvalue(FM, theta), 1.0 - np.exp(-1j * theta), atol=1e-15)
    weighed = sum(c * 2.0 * (1.0 - np.cos(j * theta)) for j, c in enumerate(MBCM3.ahead, start=1))
    np.testing.assert_allclose(eigenvalue(MBCM3, theta), weighed, atol=1e-15)


def ring_matrix(coupling: Coupling, g: Gains, n: int) -> Floats:
    """Return the matrix of d/dt of (positions, speeds) of the whole ring."""
    laplacian = np.zeros((n, n))
    for sign, weights in ((-1, coupling.ahead), (1, coupling.behind)):
        for j, weight in enumerate(weights, start=1):
            for i in range(n):
                laplacian[i, i] += weight
                laplacian[i, (i + sign * j) % n] -= weight
    above = np.hstack([np.zeros((n, n)), np.eye(n)])
    below = np.hstack([-g.k_d * laplacian, -g.k_v * laplacian - g.k_c * np.eye(n)])
    return np.vstack([above, below])


@settings(deadline=None, max_examples=40)
@given(COUPLINGS, GAINS, st.integers(3, 14))
def test_modes_are_the_eigenvalues_of_the_whole_ring(c: Coupling, g: Gains, n: int) -> None:
    lam = eigenvalue(c, 2.0 * np.pi * np.arange(n) / n)
    mine = roots(lam, g).ravel()
    whole = np.linalg.eigvals(ring_matrix(c, g, n))
    for s in mine:  # equal roots are only found to the square root of the precision
        assert np.abs(whole - s).min() < 1e-5
    slowest = slowest_mode(c, g, n)
    others = np.sort(whole.real)[::-1]
    shift = np.argmin(np.abs(others))  # a shift of all vehicles: s = 0 and s = -k_c
    others = np.delete(others, [shift])
    others = np.delete(others, [np.argmin(np.abs(others + g.k_c))])
    assert slowest.rate == pytest.approx(others.max(), abs=1e-5)


def test_bcm_on_the_papers_ring() -> None:
    """The roots solve s² + (k_v λ + k_c) s + k_d λ = 0 with λ = 2 (1 - cos(2π/40))."""
    lam = 2.0 * (1.0 - np.cos(2.0 * np.pi / 40.0))
    rate = -(0.5 * lam + 0.05) / 2.0
    mode = slowest_mode(BCM, PAPER, 40)
    assert mode.number == 1
    assert mode.rate == pytest.approx(rate)
    assert mode.omega == pytest.approx(np.sqrt(0.1 * lam - rate**2))
    assert slowest_mode(MBCM3, PAPER, 40).rate < mode.rate  # MBCM damps it faster
    assert slowest_mode(FM, PAPER, 40).rate > 0.0  # FM amplifies
    assert len(modes(BCM, PAPER, 40)) == 20
    assert slowest_mode(FM, Gains(k_d=0.02, k_v=0.5, k_c=0.1), 40).rate < 0.0


def right_of(edge: float, lam: complex, g: Gains, tau: float, lag: float) -> float:
    """Return how many roots have a real part above `edge`: the winding number of f around 0."""
    a, b = abs(g.k_v * lam + g.k_c), abs(g.k_d * lam)
    grown = max(1.0, float(np.exp(-edge * tau))) / abs(1.0 + min(edge, 0.0) * lag)
    far = 1.5 * (a * grown + np.sqrt(b * grown)) + 1.0  # beyond, s² outweighs the law
    side = np.linspace(-far, far, 40_001)
    path = np.concatenate(
        [
            edge + 1j * side[::-1],
            np.linspace(edge, edge + 2.0 * far, 5_001) - 1j * far,
            edge + 2.0 * far + 1j * side,
            np.linspace(edge + 2.0 * far, edge, 5_001) + 1j * far,
        ]
    )
    law = (g.k_v * lam + g.k_c) * path + g.k_d * lam
    f = (lag * path + 1.0) * path**2 + law * np.exp(-path * tau)
    return float(np.angle(f[1:] / f[:-1]).sum() / (2.0 * np.pi))


@settings(deadline=None, max_examples=60)
@given(
    COUPLINGS,
    GAINS,
    st.integers(3, 60),
    st.integers(1, 30),
    st.floats(0.01, 1.5),
    st.one_of(st.just(0.0), st.floats(0.05, 1.5)),
)
def test_roots_with_delay_are_the_dominant_ones(
    c: Coupling, g: Gains, n: int, number: int, tau: float, lag: float
) -> None:
    lam = eigenvalue(c, np.array([2.0 * np.pi * (1 + number % (n // 2)) / n]))
    s = roots(lam, g, tau, lag)[:, 0]
    law = (g.k_v * lam + g.k_c) * s + g.k_d * lam
    np.testing.assert_allclose((lag * s + 1.0) * s * s + law * np.exp(-s * tau), 0.0, atol=1e-7)
    assert s[0].real >= s[1].real - 1e-9
    above, below = (
        right_of(s[0].real + step, complex(lam[0]), g, tau, lag) for step in (2e-3, -2e-3)
    )
    assert above == pytest.approx(0.0, abs=1e-6)
    assert below > 0.9


@given(COUPLINGS, GAINS, st.integers(3, 60), st.floats(0.01, 3.0))
def test_roots_with_a_lag_are_those_of_the_cubic(c: Coupling, g: Gains, n: int, lag: float) -> None:
    lam = eigenvalue(c, np.array([2.0 * np.pi / n]))
    cubic = np.roots([lag, 1.0, g.k_v * lam[0] + g.k_c, g.k_d * lam[0]])
    found = roots(lam, g, 0.0, lag)[:, 0]
    assert (np.diff(found.real) <= 1e-9).all()
    for root in cubic:
        assert np.abs(found - root).min() < 1e-5


@given(GAINS)
def test_a_lag_makes_a_vehicle_swing_as_routh_says(g: Gains) -> None:
    """T s³ + s² + (k_v + k_c) s + k_d has its roots on the left for k_v + k_c > T k_d."""
    edge_s = (g.k_v + g.k_c) / g.k_d
    assert is_stable([Member(FM, g, 0.0, 0.999 * edge_s)])
    assert not is_stable([Member(FM, g, 0.0, 1.001 * edge_s)])


@pytest.mark.parametrize("k_d", [0.25, 0.25001, 0.24999, 0.26])
def test_a_delay_splits_the_roots_of_a_critically_damped_mode(k_d: float) -> None:
    g = Gains(k_d=k_d, k_v=0.0, k_c=1.0)  # s² + s + 0.25 with λ = 1
    s = roots(np.array([1.0 + 0j]), g, 0.1)[:, 0]
    assert abs(s[0] - s[1]) > 0.1
    np.testing.assert_allclose(s * s + (s + k_d) * np.exp(-0.1 * s), 0.0, atol=1e-9)


def test_a_long_delay_makes_a_mode_grow() -> None:
    """The root jω of s² + a s e^(-sτ) is on the edge for aτ = π/2, with ω = a."""
    g = Gains(k_d=0.0, k_v=0.0, k_c=1.0)
    below, above = (roots(np.array([0j]), g, tau)[0, 0] for tau in (1.55, 1.59))
    assert below.real <= 1e-9  # besides s = 0, which is always there
    assert above.real > 0.0
    assert abs(above.imag) == pytest.approx(1.0, rel=0.02)


@pytest.mark.parametrize("coupling", [BCM, MBCM3, mbcm(weights_of("uniform", 2))])
def test_long_waves_of_bilateral_laws_have_their_speed(coupling: Coupling) -> None:
    undamped = Gains(k_d=0.1, k_v=0.5, k_c=0.0)
    phase, group = wave_speeds(coupling, undamped, 1e-2)
    expected = long_wave_speed(coupling, undamped)
    assert phase == pytest.approx(expected, rel=1e-3)
    assert group == pytest.approx(expected, rel=1e-3)
    variance = sum(c * j * j for j, c in enumerate(coupling.ahead, start=1))
    assert expected == pytest.approx(np.sqrt(0.1 * variance))
    creeping = wave_speeds(coupling, Gains(k_c=0.5), 1e-3)
    assert creeping == pytest.approx((0.0, 0.0), abs=1e-12)


def test_long_waves_of_fm_are_kinematic() -> None:
    phase, group = wave_speeds(FM, PAPER, 1e-4)
    assert long_wave_speed(FM, PAPER) == pytest.approx(2.0)  # k_d / k_c
    assert phase == pytest.approx(2.0, rel=1e-4)
    assert group == pytest.approx(2.0, rel=1e-4)
    assert long_wave_speed(FM, Gains(k_c=0.0)) == float("inf")
    assert metres_per_second(2.0, 37.5, 30.0) == -45.0
