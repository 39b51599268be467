"""A step of a link's covariance in plain floats: the products of filterpy, in their order.

filterpy multiplies arrays of Python's floats, and spends nearly all of its time on the arrays. The
same products one by one give the same bits in a tenth of the time. A test compares the two.
"""

from __future__ import annotations

from typing import NamedTuple

Matrix = tuple[float, float, float, float]
"""A matrix (2, 2), row by row."""


class Model(NamedTuple):
    """F, Q and R of a filter whose H is the identity."""

    F: Matrix
    Q: Matrix
    R: Matrix


def predicted(P: Matrix, model: Model) -> Matrix:
    """Return P' = F P Fᵀ + Q."""
    return _sum(_product(_product(model.F, P), _transposed(model.F)), model.Q)


def updated(P: Matrix, model: Model) -> tuple[Matrix, Matrix]:
    """Return P and K after an update; raises ZeroDivisionError if S is singular."""
    to_state = _product(P, _IDENTITY)
    a, b, c, d = _sum(_product(_IDENTITY, to_state), model.R)
    determinant = a * d - b * c
    K = _product(to_state, (d / determinant, -b / determinant, -c / determinant, a / determinant))
    kept = _difference(_IDENTITY, _product(K, _IDENTITY))
    through = _product(_product(kept, P), _transposed(kept))
    return _sum(through, _product(_product(K, model.R), _transposed(K))), K


_IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0)


def _product(one: Matrix, other: Matrix) -> Matrix:
    a, b, c, d = one
    e, f, g, h = other
    return a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h


def _transposed(one: Matrix) -> Matrix:
    a, b, c, d = one
    return a, c, b, d


def _sum(one: Matrix, other: Matrix) -> Matrix:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2], one[3] + other[3]


def _difference(one: Matrix, other: Matrix) -> Matrix:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2], one[3] - other[3]
