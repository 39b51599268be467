"""Arithmetic of arrays that raises where arithmetic of floats raises."""

from __future__ import annotations

from contextlib import AbstractContextManager

import numpy as np


def strict_arithmetic() -> AbstractContextManager[object]:
    """Return a context in which a division of an array by 0 raises FloatingPointError.

    By default numpy warns and returns infinity, which a law may turn into a finite acceleration.
    """
    return np.errstate(divide="raise", invalid="raise", over="ignore", under="ignore")
