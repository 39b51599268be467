"""Arithmetic of arrays that fails where that of floats does."""

from __future__ import annotations

from contextlib import AbstractContextManager

import numpy as np


def strict_arithmetic() -> AbstractContextManager[object]:
    """Raise FloatingPointError where an array is divided by 0, as floats raise.

    numpy would warn and go on with infinity, which a law may turn into a finite acceleration.
    """
    return np.errstate(divide="raise", invalid="raise", over="ignore", under="ignore")
