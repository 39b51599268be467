"""The filter of Singer's model has the gains of scipy's Riccati equation, and follows motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_are, solve_discrete_are

from zenvoy.laws import Relative
from zenvoy.laws.singer import Singer, Track, corrected, predicted, steady_gains

Matrix = NDArray[np.float64]

MODEL = Singer(0.8, 1.68, 0.17, 0.13)
READINGS = np.eye(3)[:2]


def transition(model: Singer, period_s: float) -> Matrix:
    """Return the transition by what the filter predicts for each unit state."""
    columns = [predicted(Track(*unit), 0.0, model, period_s) for unit in np.eye(3)]
    return np.array(columns).T


def reference(model: Singer, period_s: float) -> Matrix:
    """Return the gain of the Kalman filter for both readings at once, by scipy."""
    t, q = period_s, 2.0 * model.acceleration_std_mps2**2 / model.manoeuvre_s
    noise = q * np.array(
        [
            [t**5 / 20, t**4 / 8, t**3 / 6],
            [t**4 / 8, t**3 / 3, t**2 / 2],
            [t**3 / 6, t**2 / 2, t],
        ]
    )
    error = np.diag([model.gap_std_m**2, model.speed_std_mps**2])
    p = solve_discrete_are(transition(model, t).T, READINGS.T, noise, error)
    return np.asarray(p @ READINGS.T @ np.linalg.inv(READINGS @ p @ READINGS.T + error))


@given(
    st.floats(0.1, 10.0),
    st.floats(0.1, 5.0),
    st.floats(0.02, 2.0),
    st.floats(0.02, 2.0),
    st.sampled_from([0.01, 0.02, 0.1]),
)
def test_gains_are_those_of_the_steady_state(
    manoeuvre_s: float, a: float, gap: float, speed: float, period_s: float
) -> None:
    model = Singer(manoeuvre_s, a, gap, speed)
    gains = steady_gains(model, period_s)
    # The speed is read after the gap: what the gap's error does to it is corrected, too.
    one_by_one = np.array(gains.gap) - np.array(gains.speed) * gains.gap[1]
    expected = reference(model, period_s)
    np.testing.assert_allclose(np.array(gains.speed), expected[:, 1], rtol=1e-9)
    np.testing.assert_allclose(one_by_one, expected[:, 0], rtol=1e-7, atol=1e-12)


def test_a_short_period_has_the_gains_of_continuous_readings() -> None:
    """With readings of density R / T, gains divided by T become those of Kalman and Bucy."""
    period_s = 0.001
    a = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / MODEL.manoeuvre_s]])
    noise = np.diag([0.0, 0.0, 2.0 * MODEL.acceleration_std_mps2**2 / MODEL.manoeuvre_s])
    error = np.diag([MODEL.gap_std_m**2, MODEL.speed_std_mps**2]) * period_s
    p = solve_continuous_are(a.T, READINGS.T, noise, error)
    expected = p @ READINGS.T @ np.linalg.inv(error)
    gains = np.array(steady_gains(MODEL, period_s)).T / period_s
    np.testing.assert_allclose(gains, expected, rtol=0.15, atol=0.2)


@given(st.floats(1.0, 100.0), st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), st.floats(0.001, 1.0))
def test_a_prediction_is_exact_without_acceleration_ahead(
    p: float, v: float, own: float, t: float
) -> None:
    track = predicted(Track(p, v, 0.0), own, MODEL, t)
    assert track == pytest.approx((p + v * t - 0.5 * own * t * t, v - own * t, 0.0), abs=1e-9)


def test_an_acceleration_decays_with_the_time_constant() -> None:
    track = Track(0.0, 0.0, 1.0)
    for _ in range(100):
        track = predicted(track, 0.0, MODEL, 0.01)
    tau = MODEL.manoeuvre_s
    left = math.exp(-1.0 / tau)
    assert track.a == pytest.approx(left, rel=1e-4)
    assert track.v == pytest.approx(tau * (1.0 - left), rel=1e-4)
    assert track.p == pytest.approx(tau * (1.0 - tau * (1.0 - left)), rel=1e-4)


@pytest.mark.parametrize("frequency_hz", [0.05, 0.3, 2.0])
def test_the_estimate_is_the_response_of_the_filter(frequency_hz: float) -> None:
    """The vehicle ahead oscillates, and the host brakes and accelerates in its own rhythm."""
    period_s, omega = 0.02, 2.0 * math.pi * frequency_hz
    gains = steady_gains(MODEL, period_s)
    k = reference(MODEL, period_s)
    z = np.exp(1j * omega * period_s)
    f = transition(MODEL, period_s)
    speed, gap = 1.0 / (1j * omega), 1.0 / (1j * omega) ** 2  # for an acceleration of 1 m/s²
    kept = np.eye(3) - k @ READINGS
    state: Any = np.linalg.solve(z * np.eye(3) - kept @ f, z * (k @ np.array([gap, speed])))
    track, found = Track(0.0, 0.0, 0.0), []
    times = np.arange(0.0, 40.0, period_s)
    for t in times.tolist():
        now, before = _own(t), _own(t - period_s)
        ahead_v, ahead_p = (
            (speed * np.exp(1j * omega * t)).real,
            (gap * np.exp(1j * omega * t)).real,
        )
        read = Relative(ahead_p - now[0], ahead_v - now[1])
        mean = (now[1] - before[1]) / period_s
        track = corrected(predicted(track, mean, MODEL, period_s), read, gains)
        found.append(track.a)
    expected = (state[2] * np.exp(1j * omega * times)).real
    late = times > 20.0
    assert np.abs(np.array(found) - expected)[late].max() < 2e-3


def _own(t: float) -> tuple[float, float]:
    """Return position and speed of the host, m and m/s."""
    return -math.sin(1.3 * t) / 1.69, -math.cos(1.3 * t) / 1.3
