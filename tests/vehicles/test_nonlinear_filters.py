"""The EKF and the UKF agree with the plain filter, since the models of a link are linear."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.conftest import run
from zenvoy.analysis import read_fleet
from zenvoy.laws import NoParameters
from zenvoy.laws.by_name import ESTIMATORS
from zenvoy.scenarios import Estimator
from zenvoy.vehicles.estimator import Filter
from zenvoy.vehicles.filters import StateFilter, state_filter
from zenvoy.vehicles.linear import linear_model
from zenvoy.vehicles.nonlinear import EXTENDED, UNSCENTED, TrackingFilter

Floats = NDArray[np.float64]
Variances = tuple[float, ...]
Kind = Literal["ekf", "ukf"]
BY_KIND = {"ekf": EXTENDED, "ukf": UNSCENTED}
KINDS: list[Kind] = ["ekf", "ukf"]

T_NS = 100_000_000
NO_ERROR = 1e-6  # the variance of readings without error, 1 mm or 1 mm/s


def new(kind: Literal["kalman", "ekf", "ukf"]) -> StateFilter:
    return state_filter(Estimator(kind=kind), T_NS)


def assert_agree(other: StateFilter, plain: StateFilter, tolerance: float, what: str) -> None:
    std = np.array(plain.std)
    # A relative speed comes from differences of gaps, so it has the rounding of the gap.
    scale = tolerance * max(1.0, float(np.abs(plain.x).max()))
    np.testing.assert_allclose(other.x, plain.x, rtol=tolerance, atol=scale, err_msg=what)
    # Each entry is scaled by its standard deviations, which may differ by factors of thousands.
    wrong = np.abs(other.P - plain.P) / np.outer(std, std)
    assert wrong.max() < tolerance, f"P, {what}: {wrong}"
    np.testing.assert_allclose(other.std, std, rtol=tolerance, err_msg=f"std, {what}")


def compare(
    kind: Kind,
    *,
    steps: int,
    phases: list[Variances],
    periods: Callable[[], int],
    period_s: float = 0.1,
    acceleration_std: float = 0.5,
    tolerance: float = 1e-9,
    seed: int = 1,
) -> None:
    """Run both over readings, `periods` apart, of a state that moves as they assume.

    R goes through `phases`, each for an equal part of the steps.
    """
    size = len(phases[0])
    other = TrackingFilter(BY_KIND[kind], NoParameters(), period_s, acceleration_std)
    plain = Filter(period_s, acceleration_std)
    F, B, _ = linear_model(period_s, acceleration_std, size)
    random = np.random.default_rng(seed)
    state = np.array([37.5, 0.0])[-size:]
    for step in range(steps):
        variances = phases[step * len(phases) // steps]
        inputs = random.uniform(-3.0, 3.0, size=periods())
        for acts in inputs + random.normal(0.0, acceleration_std, len(inputs)):
            state = F @ state + B[:, 0] * acts
        z = tuple((state + random.normal(0.0, np.sqrt(variances))).tolist())
        other.step(inputs.tolist(), z, variances)
        plain.step(inputs.tolist(), z, variances)
        assert_agree(other, plain, tolerance, f"step {step}")


variances = st.floats(0.1, 20.0) | st.just(NO_ERROR)


@settings(deadline=None, max_examples=40)
@given(
    kind=st.sampled_from(KINDS),
    period_s=st.sampled_from([0.06, 0.1, 0.25, 1.0]),
    acceleration_std=st.floats(0.05, 3.0),
    loss=st.sampled_from([0.0, 0.05, 0.3, 0.6]),
    phases=st.integers(1, 2).flatmap(
        lambda size: st.lists(st.tuples(*[variances] * size), min_size=1, max_size=3)
    ),
    seed=st.integers(0, 2**32),
)
def test_each_kind_agrees_with_the_plain_filter(
    kind: Kind,
    period_s: float,
    acceleration_std: float,
    loss: float,
    phases: list[Variances],
    seed: int,
) -> None:
    lost = np.random.default_rng(seed + 1)
    compare(
        kind,
        period_s=period_s,
        acceleration_std=acceleration_std,
        steps=100,
        phases=phases,
        periods=lambda: min(int(lost.geometric(1.0 - loss)), 20),
        seed=seed,
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "phases",
    [
        [(4.6875, 3.0)],
        [(4.6875, 3.0), (0.3, 3.3e-5), (4.6875, 3.0)],  # a queue that stops and moves on
        [(3.0,)],
    ],
)
def test_each_kind_agrees_over_a_long_time(kind: Kind, phases: list[Variances]) -> None:
    lost = np.random.default_rng(3)
    compare(
        kind,
        steps=3_000,
        phases=phases,
        periods=lambda: 1 + int(lost.random() < 0.05) * int(lost.integers(1, 10)),
        seed=7,
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("period_s", "tolerance"), [(0.1, 1e-9), (1.0, 1e-8), (10.0, 1e-3)])
@pytest.mark.parametrize("size", [1, 2])
def test_a_perfect_reading_after_a_long_silence_keeps_precision(
    kind: Kind, period_s: float, tolerance: float, size: int
) -> None:
    """In the worst case, 1e-16 of P' remains, so no difference may cancel it."""
    compare(
        kind,
        period_s=period_s,
        acceleration_std=3.0,
        steps=8,
        phases=[(NO_ERROR,) * size],
        periods=iter([1, 1, 100, 1, 100, 100, 1, 1]).__next__,
        tolerance=tolerance,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_two_readings_may_have_the_same_time(kind: Kind) -> None:
    compare(
        kind,
        steps=30,
        phases=[(4.6875, 3.0)],
        periods=iter([1, 0, 2, 0, 0] * 6).__next__,
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [1, 2])
def test_covariances_stay_positive_definite_and_symmetric(kind: Kind, size: int) -> None:
    one = new(kind)
    random = np.random.default_rng(5)
    for _ in range(2_000):
        inputs = (0.0,) * int(random.choice([1, 1, 1, 2, 50]))
        error = float(random.choice([NO_ERROR, 5.0, 1e4]))
        one.step(inputs, (30.0,) * size, (error, 3.0)[-size:])
        np.testing.assert_allclose(one.P, one.P.T, rtol=1e-9)
        np.linalg.cholesky(one.P)  # raises if it is not


@pytest.mark.parametrize("kind", ["kalman", *KINDS])
def test_each_kind_starts_from_the_first_reading_and_again_after_a_reset(
    kind: Literal["kalman", "ekf", "ukf"],
) -> None:
    link = new(kind)
    assert [*link.x, *link.std] == []
    with pytest.raises(ValueError, match="no measurement"):
        _ = link.P
    for _ in range(2):
        link.step((1.0, 2.0), (37.5, 1.0), (4.0, 9.0))
        assert link.x == (37.5, 1.0)
        assert link.P.tolist() == [[4.0, 0.0], [0.0, 9.0]]
        assert link.std == (2.0, 3.0)
        link.step((1.0,), (37.0, 2.0), (4.0, 9.0))
        assert all(type(value) is float for value in (*link.x, *link.std))
        assert link.x != (37.0, 2.0)
        link.reset()
        assert [*link.x, *link.std] == []


def test_a_reading_is_weighted_by_its_variance() -> None:
    """One update of the speed by hand has P' = 3 + 0.25 · 0.01 and K = P' / (P' + R)."""
    for kind in KINDS:
        speed = new(kind)
        speed.step((), (30.0,), (3.0,))
        speed.step((2.0,), (31.0,), (1.0,))
        before = 3.0 + 0.5**2 * 0.1**2
        gain = before / (before + 1.0)
        assert speed.x[0] == pytest.approx(30.2 + gain * 0.8, rel=1e-12)
        assert speed.std[0] ** 2 == pytest.approx((1.0 - gain) * before, rel=1e-12)


def test_the_model_is_that_of_the_paper() -> None:
    link, speed = linear_model(0.1, 0.5, 2), linear_model(0.1, 0.5, 1)
    np.testing.assert_array_equal(link.F, [[1.0, 0.1], [0.0, 1.0]])
    np.testing.assert_allclose(link.B, [[0.005], [0.1]], rtol=1e-15)
    np.testing.assert_allclose(link.Q, 0.25 * link.B @ link.B.T, rtol=1e-15)
    assert [entry.tolist() for entry in speed] == [[[1.0]], [[0.1]], [pytest.approx([0.0025])]]


def test_the_setting_selects_the_filter() -> None:
    assert type(new("kalman")) is Filter
    for kind in KINDS:
        assert type(new(kind)) is TrackingFilter
    assert ESTIMATORS.taken() == ("kalman", *KINDS)
    assert Estimator().kind == "kalman"


LOSSY = """
duration_s: 6
fleet: {size: 5}
control: {model: FM, schedule: [{at_s: 1, model: PBCM}]}
channel: {loss: {p: 0.2}}
events: [{vehicle: 3, at_s: 2, duration_s: 2, deceleration_mps2: 3}]
"""


def truth(out: Path) -> Floats:
    """Return position and speed of each vehicle, (2, cycles + 1, vehicles)."""
    table = read_fleet(out / "out" / "run.mcap")["/fleet/truth"]
    return np.stack([table["position"], table["speed"]])


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_is_the_same_on_both_buses_and_as_with_the_plain_filter(
    kind: Kind, tmp_path: Path
) -> None:
    chosen = ("--set", f"estimator.kind={kind}")
    zenoh = run(tmp_path / "zenoh", LOSSY, "--bus", "zenoh", *chosen)
    single = run(tmp_path / "single", LOSSY, "--bus", "in-process", *chosen)
    plain = run(tmp_path / "plain", LOSSY, "--bus", "in-process")
    assert zenoh.result["fingerprint"] == single.result["fingerprint"]
    # The bits differ, so the plain filter did not run.
    assert single.result["fingerprint"] != plain.result["fingerprint"]
    np.testing.assert_allclose(truth(tmp_path / "single"), truth(tmp_path / "plain"), atol=1e-9)
