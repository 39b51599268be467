"""The filter agrees with filterpy's KalmanFilter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.vehicles.reading_errors import gap_error, speed_error
from zenvoy.scenarios import Estimator
from zenvoy.vehicles.estimator import Filter, ReadingError
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.state import SpeedState

Floats = NDArray[np.float64]
Variances = tuple[float, ...]


class Plain:
    """filterpy's filter: predict once per input, and update once per measurement."""

    def __init__(self, period_s: float, acceleration_std: float, size: int) -> None:
        kalman = KalmanFilter(dim_x=size, dim_z=size, dim_u=1)
        kalman.F = np.array([[1.0, period_s], [0.0, 1.0]])[-size:, -size:]
        kalman.B = np.array([[period_s**2 / 2], [period_s]])[-size:]
        kalman.H = np.eye(size)
        kalman.Q = acceleration_std**2 * kalman.B @ kalman.B.T
        self.kalman = kalman
        self.started = False

    def step(self, inputs: Sequence[float], z: Sequence[float], variances: Variances) -> None:
        kalman, column = self.kalman, np.array(z).reshape(-1, 1)
        if not self.started:
            kalman.x, kalman.P, self.started = column, np.diag(variances), True
            return
        for a in inputs:
            kalman.predict(u=np.array([[a]]))
        kalman.update(column, R=np.diag(variances))


def assert_agree(ours: Filter, plain: Plain, step: int) -> None:
    state, covariance = plain.kalman.x.ravel(), plain.kalman.P
    np.testing.assert_allclose(ours.x, state, rtol=1e-9, atol=1e-9, err_msg=f"x, step {step}")
    # Each entry is scaled by its standard deviations, which may differ by factors of thousands.
    std = np.sqrt(np.diag(covariance))
    wrong = np.abs(ours.P - covariance) / np.outer(std, std)
    assert wrong.max() < 1e-9, f"P, step {step}"
    np.testing.assert_allclose(ours.std, std, rtol=1e-9)


def compare(
    *,
    period_s: float,
    acceleration_std: float,
    steps: int,
    loss: float,
    phases: Sequence[Variances],
    seed: int,
) -> None:
    """Run both over random readings. R goes through `phases`, each for an equal part of them."""
    size = len(phases[0])
    ours = Filter(period_s, acceleration_std)
    plain = Plain(period_s, acceleration_std, size)
    random = np.random.default_rng(seed)
    for step in range(steps):
        variances = phases[step * len(phases) // steps]
        # Each period without loss has a measurement. The others have only their input.
        inputs = random.uniform(-3.0, 3.0, size=min(int(random.geometric(1.0 - loss)), 20))
        z = tuple(random.uniform(-40.0, 40.0, size=size).tolist())
        ours.step(inputs.tolist(), z, variances)
        plain.step(inputs.tolist(), z, variances)
        if step % 7 == 0 or step > steps - 20:
            assert_agree(ours, plain, step)


periods = st.sampled_from([0.06, 0.1, 0.25, 1.0])
stds = st.floats(0.05, 3.0)
losses = st.sampled_from([0.0, 0.0, 0.05, 0.3, 0.6])
seeds = st.integers(0, 2**32)


@settings(deadline=None, max_examples=25)
@given(
    periods,
    stds,
    losses,
    st.lists(st.tuples(st.floats(5.0, 120.0), st.floats(0.0, 40.0)), min_size=1, max_size=4),
    seeds,
)
def test_a_link_agrees_with_filterpy(
    period_s: float,
    acceleration_std: float,
    loss: float,
    sizes: list[tuple[float, float]],
    seed: int,
) -> None:
    gap_errors, speed_errors = gap_error(), speed_error()
    phases = [(gap_errors.variance(gap), speed_errors.variance(speed)) for gap, speed in sizes]
    compare(
        period_s=period_s,
        acceleration_std=acceleration_std,
        steps=150,
        loss=loss,
        phases=phases,
        seed=seed,
    )


@settings(deadline=None, max_examples=15)
@given(periods, stds, losses, st.lists(st.floats(0.0, 40.0), min_size=1, max_size=4), seeds)
def test_a_speed_agrees_with_filterpy(
    period_s: float, acceleration_std: float, loss: float, speeds: list[float], seed: int
) -> None:
    errors = speed_error()
    phases = [(errors.variance(speed),) for speed in speeds]
    compare(
        period_s=period_s,
        acceleration_std=acceleration_std,
        steps=150,
        loss=loss,
        phases=phases,
        seed=seed,
    )


LONG: list[list[Variances]] = [
    [(4.6875, 3.0)],
    [(4.6875, 3.0), (0.3, 3.3e-5), (4.6875, 3.0)],  # a queue that stops and moves on
    [(3.0,)],
    [(3.0,), (3.3e-5,)],
]


@pytest.mark.parametrize("phases", LONG)
@pytest.mark.parametrize("loss", [0.0, 0.02])
def test_the_filter_agrees_long_after_the_gain_has_settled(
    phases: list[Variances], loss: float
) -> None:
    compare(period_s=0.1, acceleration_std=0.5, steps=1_500, loss=loss, phases=phases, seed=7)


@pytest.mark.parametrize("size", [1, 2])
def test_without_measurement_error_the_estimate_is_the_reading(size: int) -> None:
    variance = ReadingError(0.0, 37.5).variance(37.5)
    assert 0.0 < variance <= 1e-6
    compare(
        period_s=0.1,
        acceleration_std=0.5,
        steps=700,
        loss=0.1,
        phases=[(variance,) * size],
        seed=3,
    )
    one = Filter(0.1, 0.5)
    for k in range(100):
        one.step((0.0,), (30.0 + 0.001 * k,), (variance,))
    assert one.x[0] == pytest.approx(30.099, abs=1e-4)


def test_the_filter_starts_from_the_first_measurement_and_again_after_a_reset() -> None:
    link = Filter(0.1, 0.5)
    assert [*link.x, *link.std] == []
    with pytest.raises(ValueError, match="no measurement"):
        _ = link.P
    for _ in range(2):
        link.step((1.0, 2.0), (37.5, 1.0), (4.0, 9.0))
        assert list(link.x) == [37.5, 1.0]
        assert link.P.tolist() == [[4.0, 0.0], [0.0, 9.0]]
        assert link.std == (2.0, 3.0)
        link.step((1.0,), (37.0, 2.0), (4.0, 9.0))
        assert list(link.x) != [37.0, 2.0]
        link.reset()
        assert [*link.x, *link.std] == []


@given(st.floats(0.0, 0.5), st.floats(0.0, 200.0), st.lists(st.floats(0.0, 200.0), max_size=20))
def test_variance_of_a_reading_follows_its_size(
    share: float, nominal: float, values: list[float]
) -> None:
    error = ReadingError(share, nominal)
    assert error.variance(nominal) == pytest.approx(max(share * max(nominal, 0.1), 1e-3) ** 2)
    for value in values:
        exact = max(share * max(value, 0.1), 1e-3) ** 2
        assert 1.25**-2 * 0.999 <= error.variance(value) / exact <= 1.25**2 * 1.001


def test_the_own_speed_is_predicted_over_missed_readings() -> None:
    """If readings have no error and the motion is known, predictions equal readings."""
    period_ns = 100_000_000
    own = Motion(keep_ns=10**12)
    state = SpeedState(period_ns, Estimator(), speed_error(), own)
    speed = 30.0
    for cycle, a in enumerate([0.0, 1.0, -2.0, 3.0, 1.5, -1.0, 0.5, 2.0]):
        time_ns = cycle * period_ns
        own.learn(time_ns - period_ns, time_ns, a, (), ())
        speed += 0.1 * a
        if cycle not in {2, 3, 4, 6}:
            state.measure(time_ns, speed)
            assert state.estimate == pytest.approx(speed, abs=1e-9)
    state.measure(time_ns + 200 * period_ns, 12.0)  # too long: the filter starts again
    assert state.estimate == 12.0
