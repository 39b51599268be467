"""How well values agree with the truth."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.measures.metrics import accuracy


class Agreement(NamedTuple):
    """RMSE in the values' unit, both meanings of "R²", and the number of values.

    `r2` is 1 - SS_res / SS_tot. It is negative where offset or noise exceed the variation of the
    truth. `r2_correlation` is the square of Pearson's correlation coefficient, which ignores offset
    and scale. Both are NaN where the truth does not vary, the latter also where the values do not.
    `spread` is the standard deviation of the truth.
    """

    rmse: float
    r2: float
    r2_correlation: float
    samples: int
    spread: float


def agreement(values: NDArray[Any], truth: NDArray[Any]) -> Agreement | None:
    """Compare values with the truth, two arrays of one shape; None where there is no pair.

    Pairs with a NaN are left out. All elements are pooled: pass one column for one vehicle.
    """
    found = accuracy(values, truth)
    if found is None:
        return None
    known = ~(np.isnan(values) | np.isnan(truth))
    return Agreement(
        rmse=found.rmse,
        r2=found.r2,
        r2_correlation=_correlation(values[known], truth[known]) ** 2,
        samples=int(known.sum()),
        spread=found.spread,
    )


def _correlation(values: NDArray[Any], truth: NDArray[Any]) -> float:
    """Return Pearson's correlation coefficient; NaN where one of the two does not vary."""
    first, second = values - values.mean(), truth - truth.mean()
    scale = float(np.sqrt((first**2).sum()) * np.sqrt((second**2).sum()))
    return float((first * second).sum()) / scale if scale > 0.0 else float("nan")
