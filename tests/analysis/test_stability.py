"""Gains, waves and modes are measured correctly for motions in which they are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.analysis.measures.stability import (
    Arrivals,
    arrivals,
    decay,
    lasting,
    mode_amplitude,
    norms,
    response,
    wave_speed,
)
from zenvoy.analysis.theory.laws import transfer
from zenvoy.scenarios import Gains

Floats = NDArray[np.float64]


def test_norms_by_hand() -> None:
    found = norms(np.array([[3.0, 0.0], [-4.0, 1.0]]), 0.25)
    assert found.l2.tolist() == [2.5, 0.5]
    assert found.linf.tolist() == [4.0, 1.0]


@given(st.floats(0.1, 3.0), st.floats(0.01, 2.0))
def test_norms_of_a_decay(size: float, rate: float) -> None:
    """The integral of (A e^(-rt))² is A² / 2r."""
    time = np.arange(0.0, 12.0 / rate, 1e-3 / rate)
    found = norms(size * np.exp(-rate * time)[:, None], 1e-3 / rate)
    assert found.l2[0] == pytest.approx(size / math.sqrt(2.0 * rate), rel=2e-3)
    assert found.linf[0] == size


# --- waves --------------------------------------------------------------------------------------


def bumps(time: Floats, at: list[float], depth: list[float]) -> Floats:
    rows = [-d * np.exp(-(((time - t) / 1.5) ** 2)) for t, d in zip(at, depth, strict=True)]
    return np.array(rows).T


def test_a_dip_is_followed_and_its_speed_is_measured() -> None:
    time = np.arange(0.0, 60.0, 0.1)
    at = [3.0, 5.02, 7.04, 9.06, 11.08, 13.1]
    deviation = bumps(time, at, [5.0, 4.0, 3.0, 2.0, 1.0, 0.2])
    found = arrivals(time, deviation, np.arange(6), 0.5, 10.0)
    assert found.steps.tolist() == [0, 1, 2, 3, 4]  # the sixth is too shallow
    np.testing.assert_allclose(found.time_s, at[:5], atol=2e-3)
    assert wave_speed(found) == pytest.approx(1.0 / 2.02, rel=2e-3)


def test_dips_may_be_at_or_before_that_of_the_vehicle_ahead() -> None:
    """Under CACC all vehicles hear of a braking at once, so the wave has no order."""
    time = np.arange(0.0, 30.0, 0.1)
    at = [5.0, 5.6, 5.6, 5.3, 6.4]
    found = arrivals(time, bumps(time, at, [4.0] * 5), np.arange(5), 0.5, 10.0)
    assert found.steps.tolist() == [0, 1, 2, 3, 4]
    np.testing.assert_allclose(found.time_s, at, atol=2e-3)


def test_a_wave_is_lost_after_two_vehicles_without_a_dip() -> None:
    time = np.arange(0.0, 60.0, 0.1)
    deviation = bumps(time, [5.0, 6.0, 7.0, 8.0, 9.0, 30.0], [4.0] * 6)
    deviation[:, 2:5] = -0.2 * time[:, None]
    found = arrivals(time, deviation, np.arange(6), 0.5, 8.0)
    assert found.steps.tolist() == [0, 1]


def test_dips_without_order_have_no_speed() -> None:
    """For noise, a line through the arrivals would give hundreds of metres per second."""
    behind = np.arange(5)
    assert wave_speed(Arrivals(behind, np.array([12.0, 13.8, 13.5, 13.0, 14.2]))) is None
    assert wave_speed(Arrivals(behind, np.array([12.0, 13.0, 13.0, 13.0, 13.0]))) is None
    in_line = wave_speed(Arrivals(behind, np.array([12.0, 13.0, 13.6, 13.9, 14.8])))
    assert in_line == pytest.approx(1.75, rel=0.01)


def test_a_vehicle_without_a_dip_does_not_hide_those_behind_it() -> None:
    time = np.arange(0.0, 30.0, 0.1)
    deviation = bumps(time, [5.0, 6.0, 7.0, 8.0], [4.0] * 4)
    deviation[:, 2] = -0.2 * time  # ever slower
    found = arrivals(time, deviation, np.arange(4), 0.5, 5.0)
    assert found.steps.tolist() == [0, 1, 3]
    np.testing.assert_allclose(found.time_s, [5.0, 6.0, 8.0], atol=2e-3)


def test_a_dip_with_a_plateau_is_at_its_begin() -> None:
    time = np.arange(0.0, 10.0, 0.1)
    deviation = np.maximum(-2.0 * (time - 1.0).clip(0.0), -4.0)[:, None]
    found = arrivals(time, deviation, np.array([0]), 0.5, 20.0)
    assert found.time_s.tolist() == pytest.approx([3.0])


def test_the_first_wave_is_followed() -> None:
    time = np.arange(0.0, 60.0, 0.1)
    deviation = bumps(time, [3.0, 5.0, 7.0, 9.0], [5.0, 4.0, 3.0, 2.0])
    deviation[:, 1:] += bumps(time, [40.0] * 3, [9.0] * 3)  # another, deeper one, later
    found = arrivals(time, deviation, np.arange(4), 0.5, 10.0)
    np.testing.assert_allclose(found.time_s, [3.0, 5.0, 7.0, 9.0], atol=2e-3)
    backwards = arrivals(time, deviation[:, ::-1], np.array([3, 2, 1, 0]), 0.5, 10.0)
    np.testing.assert_allclose(backwards.time_s, found.time_s)


def test_a_speed_needs_three_vehicles() -> None:
    assert wave_speed(Arrivals(np.arange(3), np.array([0.0, 1.0, 2.0]))) is None
    assert wave_speed(Arrivals(np.arange(4), np.array([9.0, 4.0, 6.0, 8.0]))) == pytest.approx(0.5)
    assert wave_speed(Arrivals(np.arange(4), np.array([1.0, 1.0, 1.0, 1.0]))) is None


# --- frequency ----------------------------------------------------------------------------------


@pytest.mark.parametrize("returns", [True, False])
def test_the_response_of_a_vehicle_under_fm(returns: bool) -> None:
    """The input is a pulse of acceleration after which the speed returns, or does not."""
    g = Gains()
    dt, steps = 0.05, 8000
    time = np.arange(steps) * dt
    head = -np.exp(-(((time - 10.0) / 1.0) ** 2))
    if returns:
        head += np.exp(-(((time - 14.0) / 1.0) ** 2))
    speed = np.cumsum(head) * dt
    tail, v, p = np.zeros(steps), 0.0, 0.0
    for k in range(steps):  # p: gap; semi-implicit in 4 small steps
        before = v
        for _ in range(4):
            v += dt / 4.0 * (g.k_d * p + g.k_v * (speed[k] - v) - g.k_c * v)
            p += dt / 4.0 * (speed[k] - v)
        tail[k] = (v - before) / dt
    found = response(head, tail, dt, 0.05)
    theory = transfer(found.omega, g)
    assert found.omega.min() > 0.0
    assert found.omega.max() > 1.5
    np.testing.assert_allclose(np.abs(found.ratio), np.abs(theory), rtol=0.02)


def test_there_is_no_response_at_frequencies_that_the_head_lacks() -> None:
    time = np.arange(0.0, 100.0, 0.1)
    head = np.sin(2.0 * np.pi * 0.2 * time)  # 20 whole periods
    found = response(head, 2.0 * head, 0.1, 0.1)
    np.testing.assert_allclose(found.omega, [2.0 * np.pi * 0.2])
    np.testing.assert_allclose(found.ratio, [2.0])


# --- modes --------------------------------------------------------------------------------------


def test_amplitude_of_a_mode_by_hand() -> None:
    n, length = 12, 360.0
    vehicle = np.arange(n)
    even = 1000.0 - vehicle * 30.0
    wave = 1.5 * np.cos(2.0 * np.pi * 3 * vehicle / n + 0.4)
    position = np.stack([even, even + wave, 77.0 + even + wave])
    np.testing.assert_allclose(mode_amplitude(position, length, 3)[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(mode_amplitude(position, length, 3)[1:], 0.75 * np.exp(0.4j))
    np.testing.assert_allclose(mode_amplitude(position, length, 2), 0.0, atol=1e-12)


complexes = st.complex_numbers(min_magnitude=0.3, max_magnitude=1.0)


@settings(deadline=None)
@given(st.floats(-0.15, 0.05), st.floats(0.1, 0.6), complexes, complexes)
def test_exponents_of_a_standing_wave_are_found(
    rate: float, omega: float, a: complex, b: complex
) -> None:
    """The magnitude of A e^(st) + B e^(s*t) oscillates, and the rate is still found."""
    time = np.arange(0.0, 40.0, 0.1)
    swing = a * np.exp((rate + 1j * omega) * time) + b * np.exp((rate - 1j * omega) * time)
    found = decay(swing, 0.1)
    assert found is not None
    assert found.rate == pytest.approx(rate, abs=1e-6)
    assert found.omega == pytest.approx(omega, abs=1e-6)
    assert found.r2 == pytest.approx(1.0)


def test_the_slower_of_two_real_exponents_counts() -> None:
    time = np.arange(0.0, 60.0, 0.1)
    found = decay((2.0 * np.exp(-0.3 * time) - np.exp(-0.05 * time)).astype(np.complex128), 0.1)
    assert found is not None
    assert (found.rate, found.omega) == pytest.approx((-0.05, 0.0), abs=1e-6)


def test_exponents_are_found_in_noise() -> None:
    draw = np.random.default_rng(3)
    time = np.arange(0.0, 60.0, 0.1)
    swing = np.exp((-0.03 + 0.2j) * time) + 0.6 * np.exp((-0.03 - 0.2j) * time)
    noise = 0.05 * (draw.normal(size=600) + 1j * draw.normal(size=600))
    found = decay(swing + noise, 0.1)
    assert found is not None
    assert found.rate == pytest.approx(-0.03, rel=0.1)
    assert found.omega == pytest.approx(0.2, rel=0.02)
    assert found.r2 > 0.95


def test_zeros_have_no_exponents() -> None:
    assert decay(np.zeros(100, dtype=np.complex128), 0.1) is None
    assert decay(np.ones(5, dtype=np.complex128), 0.1) is None


def test_a_decay_lasts_until_it_stays_small() -> None:
    time = np.arange(0.0, 100.0, 0.1)
    swing = np.exp(-0.1 * time) * np.cos(0.5 * time)  # through zero again and again
    rows = lasting(swing.astype(np.complex128), 0.02)
    assert 32.0 < rows * 0.1 < math.log(50.0) / 0.1 + 0.2
    noisy = swing + 0.05 * np.exp(1j * 7.0 * time)  # down to 0.15 once e^(-t/10) is 0.1 to 0.2
    assert 16.0 < lasting(noisy, 0.02) * 0.1 < 24.0
    assert lasting(np.zeros(10, dtype=np.complex128), 0.02) == 0


def test_an_oscillation_at_the_end_is_no_noise() -> None:
    time = np.arange(0.0, 10.0, 0.1)
    for rate in (-0.1, 0.0, 0.3):
        assert lasting(np.exp((rate + 0.4j) * time), 0.02) == 100
