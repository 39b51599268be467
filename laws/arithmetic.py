"""Choices and roots that give the same bits on floats and on arrays.

A law runs on floats in a vehicle's process, and on arrays over seeds and vehicles in studies. An
`if` on an array is an error, so these functions replace it. Sums and products work on both already.
Transcendental functions are missing because their last bit depends on the processor. That of `**`
does, too, so `power` replaces it.
"""

from __future__ import annotations

import math

import numpy as np

from zenvoy.laws.relative import Number

_SCALARS = (float, int)


def where(condition: Number, chosen: Number, otherwise: Number) -> Number:
    """Return `chosen` where the condition holds, else `otherwise`. Both are evaluated."""
    if isinstance(condition, np.ndarray):
        return np.where(condition, chosen, otherwise)
    return chosen if condition else otherwise


def known(value: Number) -> Number:
    """Return whether a value is a number; it is NaN where a report is missing."""
    if isinstance(value, np.ndarray):
        return ~np.isnan(value)
    return not math.isnan(value)


def smaller(a: Number, b: Number) -> Number:
    """Return the smaller of both; NaN if one of them is NaN."""
    if isinstance(a, _SCALARS) and isinstance(b, _SCALARS):
        return a if a < b or math.isnan(a) else b
    return np.minimum(a, b)


def larger(a: Number, b: Number) -> Number:
    """Return the larger of both; NaN if one of them is NaN."""
    if isinstance(a, _SCALARS) and isinstance(b, _SCALARS):
        return a if a > b or math.isnan(a) else b
    return np.maximum(a, b)


def clipped(value: Number, limit: Number) -> Number:
    """Return the value within ±limit."""
    return larger(-limit, smaller(limit, value))


def share(value: Number, low: Number, high: Number) -> Number:
    """Return how far a value is on the way from `low` to `high`, within [0, 1]."""
    return larger(0.0, smaller(1.0, (value - low) / (high - low)))


def root(value: Number) -> Number:
    """Return the square root, which IEEE 754 rounds correctly; NaN below 0."""
    if isinstance(value, _SCALARS):
        return math.sqrt(value) if value >= 0.0 else math.nan
    with np.errstate(invalid="ignore"):
        return np.sqrt(value)


def power(base: Number, exponent: int) -> Number:
    """Return a power as a product; raises ValueError for an exponent below 0."""
    if exponent < 0:
        raise ValueError(f"power: the exponent {exponent} is below 0")
    result = 1.0
    for _ in range(exponent):
        result = result * base
    return result
