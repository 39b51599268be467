"""Linear theory agrees with closed forms, with eigenvalues of the system, and with simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.analysis.theory.chain import (
    Member,
    follow,
    frequency_response,
    is_stable,
    open_road,
)
from zenvoy.analysis.theory.laws import (
    BCM,
    FM,
    Coupling,
    group_delay_s,
    is_string_stable,
    mbcm,
    peak_gain,
    total_delay_s,
    transfer,
)
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
from zenvoy.scenarios import Control, Gains

Floats = NDArray[np.float64]

PAPER = Gains()  # k_d 0.1, k_v 0.5, k_c 0.05
OMEGA = np.geomspace(1e-3, 20.0, 4000)
MBCM3 = mbcm(weights_of("least-squares", 3))

gains = st.builds(
    Gains, k_d=st.floats(0.02, 1.0), k_v=st.floats(0.0, 2.0), k_c=st.floats(0.01, 1.0)
)
couplings = st.sampled_from(
    [FM, BCM, MBCM3, mbcm(weights_of("uniform", 2)), mbcm((0.7, 0.2, 0.1, 0.05))]
)


# --- one vehicle behind another -----------------------------------------------------------------


def test_weights_of_mbcm_are_those_of_the_law() -> None:
    assert weights_of("least-squares", 3) == pytest.approx((1 / 14, 4 / 14, 9 / 14))
    assert weights_of("uniform", 4) == (0.25,) * 4
    assert mbcm(weights_of("least-squares", 1)) == BCM
    assert weights_of((0.5, 0.3, 0.2), 2) == pytest.approx((0.625, 0.375))


def test_the_delay_is_wait_plus_system_delay_plus_half_a_period() -> None:
    control = Control(v2v_wait_ms=11.0, system_delay_ms=89.0)
    assert total_delay_s(control, 100.0) == pytest.approx(0.15)
    assert total_delay_s(control, 100.0, predicts=True) == pytest.approx(0.05)


def test_transfer_by_hand() -> None:
    found = transfer(np.array([0.0, 1.0]), PAPER)
    assert found[0] == 1.0
    assert found[1] == pytest.approx((0.1 + 0.5j) / (-0.9 + 0.55j))
    late = np.exp(-0.2j)
    expected = (0.1 + 0.5j) * late / (-1.0 + (0.1 + 0.55j) * late)
    assert transfer(np.array([1.0]), PAPER, 0.2)[0] == pytest.approx(expected)


@given(gains)
def test_a_string_stable_law_amplifies_no_frequency(g: Gains) -> None:
    margin = g.k_c**2 + 2.0 * g.k_v * g.k_c - 2.0 * g.k_d
    assume(abs(margin) > 1e-3)
    largest = np.abs(transfer(OMEGA, g)).max()
    assert is_string_stable(g) == (largest <= 1.0 + 1e-9)
    peak = peak_gain(g)
    assert 0.9 * peak.gain <= max(1.0, largest) <= peak.gain + 1e-9  # the grid may miss the tip
    assert (peak.omega > 0.0) == (not is_string_stable(g))
    if peak.omega:
        beside = transfer(peak.omega * np.array([0.999, 1.0, 1.001]), g)
        assert np.argmax(np.abs(beside)) == 1


def test_peak_of_the_papers_gains() -> None:
    # u = 0.1475 / (1 + √(1 + 0.25 · 0.1475 / 0.01)), by hand
    peak = peak_gain(PAPER)
    assert peak.omega == pytest.approx(np.sqrt(0.1475 / (1.0 + np.sqrt(4.6875))))
    assert peak.gain == pytest.approx(np.sqrt(0.021651 / 0.016949), rel=1e-4)  # 1.130
    assert not is_string_stable(PAPER)
    assert is_string_stable(Gains(k_d=0.02625, k_v=0.5, k_c=0.05))  # κ² + 2 k_v κ = 2 k_d exactly


@settings(deadline=None, max_examples=30)
@given(gains)
def test_the_search_for_the_peak_starts_at_the_closed_form(g: Gains) -> None:
    assume(g.k_c**2 + 2.0 * g.k_v * g.k_c - 2.0 * g.k_d < -1e-2)
    closed, searched = peak_gain(g), peak_gain(g, 1e-9)
    assert searched.gain == pytest.approx(closed.gain, rel=1e-6)
    assert searched.omega == pytest.approx(closed.omega, rel=1e-2)


@settings(deadline=None, max_examples=60)
@given(gains, st.floats(0.05, 2.0))
def test_string_stability_with_a_lag_has_its_closed_form(g: Gains, lag: float) -> None:
    """1 / |H|² - 1 has the sign of c + (1 - 2 K T) u + T² u², where u = ω² and K = k_v + k_c."""
    both = g.k_v + g.k_c
    assume(both > 1.05 * lag * g.k_d)  # a single vehicle is stable
    c, b = both**2 - g.k_v**2 - 2.0 * g.k_d, 1.0 - 2.0 * both * lag
    lowest = c if b >= 0.0 else c - 0.25 * b**2 / lag**2
    assume(abs(lowest) > 1e-3)
    assert (peak_gain(g, 0.0, lag).gain == 1.0) == (lowest > 0.0)


def test_transfer_with_a_lag_by_hand() -> None:
    s, late = 0.4j, np.exp(-0.4j * 0.2) / (1.0 + 0.4j * 0.5)
    pull = (0.5 * s + 0.1) * late
    expected = pull / (s * s + pull + 0.05 * s * late)
    assert transfer(np.array([0.4]), PAPER, 0.2, 0.5)[0] == pytest.approx(expected)


def test_a_delay_raises_the_peak() -> None:
    peaks = [peak_gain(PAPER, tau).gain for tau in (0.0, 0.1, 0.2, 0.4)]
    assert peaks == sorted(peaks)
    tame = Gains(k_d=0.05, k_v=0.5, k_c=0.1)  # just string-stable
    assert peak_gain(tame, 1e-3).gain == 1.0
    assert peak_gain(tame, 1.0).gain > 1.0


@given(gains, st.floats(0.0, 0.3))
def test_slow_waves_pass_a_vehicle_in_k_c_over_k_d(g: Gains, tau: float) -> None:
    assert group_delay_s(0.0, g, tau) == pytest.approx(g.k_c / g.k_d, rel=1e-3, abs=1e-5)


# --- the ring -----------------------------------------------------------------------------------


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
@given(couplings, gains, st.integers(3, 14))
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
    couplings,
    gains,
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


@given(couplings, gains, st.integers(3, 60), st.floats(0.01, 3.0))
def test_roots_with_a_lag_are_those_of_the_cubic(c: Coupling, g: Gains, n: int, lag: float) -> None:
    lam = eigenvalue(c, np.array([2.0 * np.pi / n]))
    cubic = np.roots([lag, 1.0, g.k_v * lam[0] + g.k_c, g.k_d * lam[0]])
    found = roots(lam, g, 0.0, lag)[:, 0]
    assert (np.diff(found.real) <= 1e-9).all()
    for root in cubic:
        assert np.abs(found - root).min() < 1e-5


@given(gains)
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


# --- a string -----------------------------------------------------------------------------------


MIXED = [FM, BCM, FM, MBCM3, BCM, MBCM3, BCM, FM]


def string(coupling: Coupling, n: int, delay_s: float, lag_s: float = 0.0) -> list[Member]:
    return open_road([Member(coupling, PAPER, delay_s, lag_s)] * n)


@pytest.mark.parametrize("lag_s", [0.0, 0.5])
def test_the_gain_of_an_fm_string_is_a_power_of_one_vehicles(lag_s: float) -> None:
    omega = np.array([0.0, 0.1, 0.27, 1.0, 3.0])
    found = frequency_response(omega, string(FM, 6, 0.2, lag_s), 0, ring=False)
    single = transfer(omega, PAPER, 0.2, lag_s)
    np.testing.assert_allclose(found, single[:, None] ** np.arange(6), rtol=1e-10)
    ring = frequency_response(omega, [Member(FM, PAPER, 0.2, lag_s)] * 6, 2, ring=True)
    np.testing.assert_allclose(ring, single[:, None] ** np.array([4, 5, 0, 1, 2, 3]), rtol=1e-10)


def test_two_vehicles_between_ends_by_hand() -> None:
    """With vehicle 2 under BCM and 3 under FM, x_2 = P (x_1 + x_3) / D and x_3 = H x_2."""
    s = 0.3j
    pull, own = 0.5 * s + 0.1, s * s + 0.05 * s
    h = pull / (own + pull)
    second = pull / (own + 2.0 * pull - pull * h)
    found = frequency_response(np.array([0.3]), string(BCM, 3, 0.0), 0, ring=False)
    np.testing.assert_allclose(found[0], [1.0, second, h * second])


def test_a_string_has_the_ends_of_the_open_road() -> None:
    members = string(MBCM3, 8, 0.1)
    sides = [member.coupling and len(member.coupling.behind) for member in members]
    assert sides == [None, 1, 2, 3, 3, 2, 1, 0]
    assert members[2].coupling == mbcm(weights_of("least-squares", 2))
    assert members[1].coupling == BCM
    assert members[7].coupling == FM
    np.testing.assert_allclose(
        frequency_response(np.array([0.2]), members, 3, ring=False)[0, 0], 0.0
    )  # vehicle 1 keeps its speed, whichever vehicle moves


def test_stable_and_unstable_strings_are_distinguished() -> None:
    stiff = Gains(k_d=0.1, k_v=2.0, k_c=0.05)
    assert is_stable(string(FM, 5, 0.15))
    assert is_stable([Member(BCM, stiff, 0.15)] * 5)
    assert not is_stable([Member(BCM, stiff, 0.25)] * 5)  # 4 k_v τ is above π/2
    assert is_stable([Member(FM, stiff, 0.25)] * 5)
    driven = Gains(k_d=0.1, k_v=0.5, k_c=-0.05)  # as the paper prints its sign
    assert is_stable([Member(FM, driven, 0.0)] * 5)
    assert not is_stable([Member(BCM, driven, 0.0)] * 5)


def brute(
    motion: Floats, dt: float, members: list[Member], source: int, ring: bool, every: int
) -> Floats:
    """Return speeds from small steps, with commands held back by their delay."""
    n = len(members)
    late = round(members[0].delay_s / dt)
    position, speed = np.zeros(n), np.zeros(n)
    waiting = [np.zeros(n)] * (late + 1)
    rows = []
    for k, v in enumerate(motion):
        speed[source] = v
        if k % every == 0:
            rows.append(speed.copy())
        a = np.zeros(n)
        for i, member in enumerate(members):
            if member.coupling is None:
                continue
            gains = member.gains
            a[i] = -gains.k_c * speed[i]
            for sign, weights in ((-1, member.coupling.ahead), (1, member.coupling.behind)):
                for j, weight in enumerate(weights, start=1):
                    other = (i + sign * j) % n
                    a[i] += weight * gains.k_d * (position[other] - position[i])
                    a[i] += weight * gains.k_v * (speed[other] - speed[i])
        waiting.append(a)
        acts = waiting.pop(0) if late else a
        position = position + dt * speed + 0.5 * dt * dt * acts
        speed = speed + dt * acts
    return np.array(rows)


@pytest.mark.parametrize(
    ("members", "ring", "source"),
    [
        (open_road([Member(law, PAPER, 0.2) for law in MIXED]), False, 0),
        (string(BCM, 7, 0.0), False, 3),
        ([Member(BCM, PAPER, 0.2), Member(FM, Gains(k_d=0.2, k_v=1.0), 0.2)] * 4, True, 2),
        ([Member(MBCM3, PAPER, 0.1)] * 9, True, 0),
    ],
)
def test_a_string_moves_like_a_brute_force_simulation(
    members: list[Member], ring: bool, source: int
) -> None:
    dt, every = 0.005, 20
    time = np.arange(12_000) * dt
    motion = -np.exp(-(((time - 8.0) / 2.0) ** 2)) * (1.0 + 0.3 * np.sin(2.0 * time))
    expected = brute(motion, dt, members, source, ring, every)
    found = follow(motion[::every], dt * every, members, source, ring=ring)
    np.testing.assert_allclose(found, expected, atol=6e-3)
