"""The record of an estimator, which filters links and a vehicle's own speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from zenvoy.laws.law import NoParameters

Array = NDArray[np.float64]
Moments = tuple[Array, Array]
"""State x (n,) and its covariance P (n, n)."""


KALMAN: Final = "kalman"
EKF: Final = "ekf"
UKF: Final = "ukf"
BUILTIN: Final = (KALMAN, EKF, UKF)
"""The names of the estimators that come with Zenvoy, which `vehicles/filters.py` makes."""


class LinearModel(NamedTuple):
    """The model x' = F x + B a + w, with F (n, n), B (n, 1) and Q (n, n), the covariance of w.

    For a link, x = [gap, relative speed] in m and m/s, and a is the relative acceleration, m/s².
    For the own speed, x = [v], m/s, and a is the own acceleration. Sensors read x itself.
    """

    F: Array
    B: Array
    Q: Array


class Tracker(Protocol):
    """A running filter that has had its first reading."""

    def step(self, inputs: Sequence[float], z: Array, R: Array) -> Moments:
        """Predict one period for each acceleration (m/s²), then update with a reading z (n,).

        There are several inputs after readings were missed. R (n, n) is the covariance of z.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimator:
    """An estimator, which `estimator.kind` names.

    start: makes a Tracker from the model, the first reading z (n,), its covariance R (n, n) and the
    parameters. parameters: a frozen dataclass with defaults; its annotations define what
    `estimator.parameters` may hold.
    """

    name: str
    start: Callable[[LinearModel, Array, Array, Any], Tracker]
    parameters: type = NoParameters
