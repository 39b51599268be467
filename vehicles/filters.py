"""The filter that a scenario chooses (`estimator.kind`): one interface, several filters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Protocol

from zenvoy.laws.estimator import KALMAN
from zenvoy.laws.parameters import parameters_of
from zenvoy.laws.table import estimator_of
from zenvoy.scenarios import Estimator
from zenvoy.vehicles.estimator import Filter
from zenvoy.vehicles.linear import Array
from zenvoy.vehicles.nonlinear import EXTENDED, UNSCENTED, TrackingFilter

_BUILTIN: Final = {one.name: one for one in (EXTENDED, UNSCENTED)}


class StateFilter(Protocol):
    """The filtered state of a link, x = [p, v], or of the own speed, x = [v]; m and m/s."""

    x: tuple[float, ...]
    """Empty before the first measurement."""

    @property
    def P(self) -> Array:
        """The covariance (n, n); raises ValueError before the first measurement."""

    @property
    def std(self) -> tuple[float, ...]:
        """The standard deviation of each entry of the state."""

    def reset(self) -> None:
        """Forget the state; the next measurement starts the filter anew."""

    def step(
        self, inputs: Sequence[float], z: tuple[float, ...], variances: tuple[float, ...]
    ) -> None:
        """Predict one period for each input (m/s²), then update with z (n,) and R's diagonal."""


def state_filter(settings: Estimator, period_ns: int, limit_s: float | None = None) -> StateFilter:
    """Return a new filter with these settings and the period of the control cycle.

    limit_s: the wall time that a step of a user's own estimator may take.
    """
    period_s, acceleration_std = period_ns * 1e-9, settings.acceleration_std_mps2
    if settings.kind == KALMAN:
        return Filter(period_s, acceleration_std)
    if settings.kind in _BUILTIN:
        return TrackingFilter(_BUILTIN[settings.kind], None, period_s, acceleration_std)
    estimator = estimator_of(settings.kind)
    parameters = parameters_of(estimator.parameters, dict(settings.parameters))
    return TrackingFilter(estimator, parameters, period_s, acceleration_std, limit_s)
