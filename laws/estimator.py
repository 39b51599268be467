"""The record of an estimator: the filter of a link, and of a vehicle's own speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from zenvoy.laws.law import NoParameters

Array = NDArray[np.float64]
Moments = tuple[Array, Array]
"""State x (n,) and its covariance P (n, n)."""


class LinearModel(NamedTuple):
    """x' = F x + B a + w: F (n, n), B (n, 1) and Q (n, n), the covariance of w.

    For a link x = [gap, relative speed] in m and m/s, and a is the relative acceleration, m/s²; for
    the own speed x = [v]. What is read is x itself.
    """

    F: Array
    B: Array
    Q: Array


class Tracker(Protocol):
    """A filter that runs, from a first reading on."""

    def step(self, inputs: Sequence[float], z: Array, R: Array) -> Moments:  # noqa: N803
        """Predict a period with each acceleration (m/s²), then take in a reading z (n,).

        There is more than one input where readings were missed. R (n, n) is the covariance of z.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimator:
    """An estimator, which `estimator.kind` names.

    start: from the model, the first reading z (n,), its covariance R (n, n) and the parameters, it
    makes a Tracker. parameters: a frozen dataclass with defaults; its annotations say what
    `estimator.parameters` may hold.
    """

    name: str
    start: Callable[[LinearModel, Array, Array, Any], Tracker]
    parameters: type = NoParameters
