"""Judges whether draws are from a distribution."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats


def agrees(draws_ms: NDArray[np.float64], cdf: Callable[[Any], Any]) -> bool:
    """Return whether draws pass a Kolmogorov-Smirnov test at 1 %, which does not see whole ns."""
    return bool(stats.kstest(draws_ms, cdf).pvalue > 0.01)
