"""Matrices of 3 × 3 in Python's floats, whose bits do not depend on the processor as BLAS's do."""

from __future__ import annotations

from typing import Final

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

IDENTITY: Final[Matrix] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def product(one: Matrix, other: Matrix) -> Matrix:
    """Return the product of two matrices."""
    first, second, third = one
    return _times(first, other), _times(second, other), _times(third, other)


def _times(row: Vector, matrix: Matrix) -> Vector:
    x, y, z = row
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return x * a + y * d + z * g, x * b + y * e + z * h, x * c + y * f + z * i


def total(one: Matrix, other: Matrix) -> Matrix:
    """Return the sum of two matrices."""
    first, second, third = (
        (a + d, b + e, c + f) for (a, b, c), (d, e, f) in zip(one, other, strict=True)
    )
    return first, second, third


def transposed(matrix: Matrix) -> Matrix:
    """Return the transpose."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return (a, d, g), (b, e, h), (c, f, i)


def inverse(matrix: Matrix) -> Matrix:
    """Return the inverse by cofactors; raises ZeroDivisionError if there is none."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    u, v, w = e * i - f * h, f * g - d * i, d * h - e * g
    determinant = a * u + b * v + c * w
    return (
        (u / determinant, (c * h - b * i) / determinant, (b * f - c * e) / determinant),
        (v / determinant, (a * i - c * g) / determinant, (c * d - a * f) / determinant),
        (w / determinant, (b * g - a * h) / determinant, (a * e - b * d) / determinant),
    )
