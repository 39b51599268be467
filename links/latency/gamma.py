"""A gamma distribution above min_ms, cut off at max_ms.

`scipy.special` loads when it is first used, because it loads more slowly than everything else that
a scenario needs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import scipy

from zenvoy.links.distribution import (
    Delays,
    Distribution,
    Floats,
    Span,
    Values,
    bounds_ms,
    portion,
    whole_ns,
)

_TAIL: Final = 0.01


def quantile(values: Values, _technology_ms: Span) -> Delays:
    """Return the quantile function."""
    low, high = bounds_ms(values)
    mean, std = (values.mean_ms or 0.0) - low, values.std_ms or 0.0
    shape, scale = (mean / std) ** 2, std**2 / mean
    within = 1.0 if high is None else float(scipy.special.gammainc(shape, (high - low) / scale))
    standard = _standard_quantile(shape)
    return lambda draws: whole_ns(low + scale * standard(portion(draws, within)))


def _standard_quantile(shape: float) -> Callable[[Floats], Floats]:
    """Return the quantile function of a gamma distribution of scale 1.

    It interpolates linearly between 8,192 points, and is exact in the tails. Exact values at half a
    microsecond each would be half the cost of a cycle. Between the tails the error is less than a
    ten-thousandth of the standard deviation.
    """
    portions = np.linspace(_TAIL, 1.0 - _TAIL, 8_192)
    points = scipy.special.gammaincinv(shape, portions)

    def standard(share: Floats) -> Floats:
        value: Floats = np.interp(share, portions, points)
        tail = (share < _TAIL) | (share > 1.0 - _TAIL)
        value[tail] = scipy.special.gammaincinv(shape, share[tail])
        return value

    return standard


LATENCY = Distribution(
    name="gamma",
    quantile=quantile,
    needs=("mean_ms", "std_ms"),
    may=("min_ms", "max_ms"),
    above_min=True,
    positive="mean_ms",
    meaning="min_ms (null: 0) and a gamma distribution above it with that mean and standard "
    "deviation",
    place=5,
)
