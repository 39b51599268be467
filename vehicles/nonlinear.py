"""The same estimates by filterpy's extended and unscented Kalman filters, for comparison.

Both filters are for nonlinear motions and readings. Those of a link are linear, so both must give
the same results as the plain filter, at a higher cost: the paper's reason not to use them. Here
f(x) = F x + B a and h(x) = x, so the Jacobians of the EKF are F and I everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from zenvoy.laws.errors import raised, shortened, useless
from zenvoy.laws.estimator import EKF, UKF, Array, Estimator, LinearModel, Moments, Tracker
from zenvoy.vehicles.filterpy_kalman import (
    ExtendedKalmanFilter,
    MerweScaledSigmaPoints,
    UnscentedKalmanFilter,
)
from zenvoy.vehicles.linear import linear_model
from zenvoy.vehicles.time_limit import time_limit


class Extended:
    """filterpy's ExtendedKalmanFilter."""

    def __init__(
        self,
        model: LinearModel,
        z: Array,
        R: Array,
        _: object = None,
    ) -> None:
        self._kalman = ExtendedKalmanFilter(dim_x=len(z), dim_z=len(z), dim_u=1)
        self._kalman.F, self._kalman.B, self._kalman.Q = model
        self._kalman.x, self._kalman.P = z, R

    def step(self, inputs: Sequence[float], z: Array, R: Array) -> Moments:
        """Predict with each acceleration (m/s²), then take in a reading."""
        for a in inputs:
            self._kalman.predict(u=np.array([a]))
        self._kalman.update(z, HJacobian=_slope, Hx=_reading, R=R)
        return self._kalman.x, self._kalman.P


class Unscented:
    """filterpy's UnscentedKalmanFilter on Van der Merwe's sigma points.

    α = 1 and κ = 3 - n put them √3 standard deviations from the mean, without negative weights;
    β = 2 is the value for Gaussian errors.
    """

    def __init__(
        self,
        model: LinearModel,
        z: Array,
        R: Array,
        _: object = None,
    ) -> None:
        size, control = len(z), model.B[:, 0]

        def moved(x: Array, _dt: None, a: float) -> Array:
            return np.asarray(model.F @ x + control * a)

        self._points = MerweScaledSigmaPoints(
            size, alpha=1.0, beta=2.0, kappa=3.0 - size, sqrt_method=upper_root
        )
        self._kalman = UnscentedKalmanFilter(
            dim_x=size, dim_z=size, dt=None, hx=_reading, fx=moved, points=self._points
        )
        self._kalman.Q = model.Q
        self._kalman.x, self._kalman.P = z, R
        self._identity = np.eye(size)

    def step(self, inputs: Sequence[float], z: Array, R: Array) -> Moments:
        """Predict with each acceleration (m/s²), then take in a reading."""
        kalman = self._kalman
        for a in inputs:
            kalman.predict(a=a)
        before = kalman.P
        if not inputs:  # otherwise the last prediction has set them
            kalman.sigmas_f = self._points.sigma_points(kalman.x, before)
        kalman.update(z, R=R)
        # filterpy subtracts K S Kᵀ, which rounding spoils if the reading is far better than the
        # prediction. With h(x) = x, Joseph's form gives the same, and stays positive.
        kept = self._identity - kalman.K
        kalman.P = kept @ before @ kept.T + kalman.K @ R @ kalman.K.T
        return kalman.x, kalman.P


_MOMENTS: Final = "state ({n},) with its covariance ({n}, {n})"

EXTENDED: Final = Estimator(name=EKF, start=Extended)
UNSCENTED: Final = Estimator(name=UKF, start=Unscented)


class TrackingFilter:
    """A filter like `estimator.Filter`, but with an estimator's tracker, which computes each gain.

    limit_s: the wall time that a step may take; None for an estimator that comes with Zenvoy.
    Raises LawError if the estimator raises, takes longer, or returns something that is not a state.
    """

    def __init__(
        self,
        estimator: Estimator,
        parameters: object,
        period_s: float,
        acceleration_std: float,
        limit_s: float | None = None,
    ) -> None:
        self._estimator, self._parameters, self._limit_s = estimator, parameters, limit_s
        self._period_s, self._acceleration_std = period_s, acceleration_std
        self._tracker: Tracker | None = None
        self._covariance: Array | None = None
        self.x: tuple[float, ...] = ()
        """State [p, v] in m and m/s, or [v]; empty before the first measurement."""

    @property
    def P(self) -> Array:
        """The covariance of the state, (n, n); raises ValueError before the first measurement."""
        if self._covariance is None:
            raise ValueError("no measurement yet")
        return self._covariance

    @property
    def std(self) -> tuple[float, ...]:
        """The standard deviation of each entry of the state, m and m/s."""
        if self._covariance is None:
            return ()
        return tuple(math.sqrt(variance) for variance in self._covariance.diagonal().tolist())

    def reset(self) -> None:
        """Forget the state; the next measurement starts the filter anew."""
        self.x, self._tracker, self._covariance = (), None, None

    def step(
        self, inputs: Sequence[float], z: tuple[float, ...], variances: tuple[float, ...]
    ) -> None:
        """Predict one period for each input, then update with z, as `Filter.step` does."""
        reading, error = np.array(z), np.diag(variances)
        estimator = self._estimator
        try:
            with time_limit(self._limit_s):
                if self._tracker is None:
                    model = linear_model(self._period_s, self._acceleration_std, len(z))
                    self._tracker = estimator.start(model, reading, error, self._parameters)
                    found = reading, error
                else:
                    found = self._tracker.step(inputs, reading, error)
        except BaseException as failure:  # the estimator may raise anything
            raise raised(f"estimator {estimator.name}", estimator.start, failure) from failure
        if not _are_moments(found, len(z)):
            text = f"returned {shortened(found)}, which is no {_MOMENTS.format(n=len(z))}"
            raise useless(f"estimator {estimator.name}", estimator.start, text)
        state, self._covariance = found
        self.x = tuple(state.tolist())


def _are_moments(found: object, size: int) -> bool:
    """Return whether an estimator has returned a finite state and its covariance."""
    if not (isinstance(found, tuple | list) and len(found) == 2):
        return False
    state, covariance = found
    if not (isinstance(state, np.ndarray) and isinstance(covariance, np.ndarray)):
        return False
    if state.shape != (size,) or covariance.shape != (size, size):
        return False
    if not {state.dtype.kind, covariance.dtype.kind} <= set("fiu"):
        return False
    return bool(np.isfinite(state).all() and (covariance.diagonal() >= 0.0).all())


def upper_root(P: Array) -> Array:
    """Return upper triangular U with Uᵀ U = P (Cholesky), for P (1, 1) or (2, 2), P[0, 0] > 0.

    A matrix that rounding has made singular has a root, too; LAPACK would fail.
    """
    if len(P) == 1:
        return np.sqrt(P)
    first = math.sqrt(P[0, 0])
    shared = P[0, 1] / first
    return np.array([[first, shared], [0.0, math.sqrt(max(0.0, P[1, 1] - shared**2))]])


def _reading(x: Array) -> Array:
    """Return h(x)."""
    return x


def _slope(x: Array) -> Array:
    """Return the Jacobian of h at x."""
    return np.eye(len(x))
