"""The linear model of a link and of the own speed from one period to the next, as matrices.

It is the model of the paper, Eq. 4 to 7: x = [p, v], F = [[1, T], [0, 1]], B = [T²/2, T]. The own
speed has the same model without its first row. Readings are the state itself (H = I).
"""

from __future__ import annotations

import numpy as np

from zenvoy.laws.estimator import Array, LinearModel

__all__ = ["Array", "LinearModel", "linear_model"]


def linear_model(period_s: float, acceleration_std: float, size: int) -> LinearModel:
    """Return the model of a state of `size` numbers, whose input a is known to within σ_a, m/s²."""
    transition = np.array([[1.0, period_s], [0.0, 1.0]])
    control = np.array([[0.5 * period_s * period_s], [period_s]])[-size:]
    noise = acceleration_std * acceleration_std * np.outer(control, control)
    return LinearModel(F=transition[-size:, -size:], B=control, Q=noise)
