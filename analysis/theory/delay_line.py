"""The motion of a vehicle under delayed commands, as ordinary differential equations."""

from __future__ import annotations

from typing import Final

import numpy as np

from zenvoy.analysis.theory.laws import Complexes, Floats

_INSTANTS: Final = 25  # at which the delay line is discretised


def delay_line(damping: Complexes, stiffness: Complexes, delay_s: float, lag_s: float) -> Complexes:
    """Return matrices (K, n, n) of d/dt, one for each of K laws u = -stiffness x - damping v.

    The states are x, v, with a lag the acceleration a, and with a delay u at past instants. The
    instants are the Chebyshev points of the delay, and u is a polynomial between them (Breda, Maset
    and Vermiglio 2005).
    """
    d, m = 3 if lag_s > 0.0 else 2, _INSTANTS if delay_s > 0.0 else 1
    lines = np.zeros((len(damping), d + m - 1, d + m - 1), dtype=np.complex128)
    lines[:, range(d - 1), range(1, d)] = 1.0  # x' = v, and v' = a if there is a lag
    if m == 1:
        lines[:, d - 1, 0], lines[:, d - 1, 1] = -stiffness, -damping
    else:
        lines[:, d - 1, -1] = 1.0  # the oldest u is the one that acts
        derivative = _derivative(delay_s, m)
        lines[:, d:, d:] = derivative[1:, 1:]
        lines[:, d:, 0] = -stiffness[:, None] * derivative[1:, 0]  # u now
        lines[:, d:, 1] = -damping[:, None] * derivative[1:, 0]
    if d == 3:
        lines[:, 2, 2] -= 1.0
        lines[:, 2] /= lag_s  # a' = (u - a) / T
    return lines


def _derivative(delay_s: float, m: int) -> Floats:
    """Return the matrix (m, m) that differentiates by time at m points, from now to the delay."""
    x = np.cos(np.pi * np.arange(m) / (m - 1))  # from 1, which is now, to -1
    weight = np.r_[2.0, np.ones(m - 2), 2.0] * (-1.0) ** np.arange(m)
    derivative = np.outer(weight, 1.0 / weight) / (x[:, None] - x[None, :] + np.eye(m))
    derivative -= np.diag(derivative.sum(axis=1))
    return np.asarray(derivative * (2.0 / delay_s))
