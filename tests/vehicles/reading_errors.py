"""The errors of readings in the tests of filters."""

from __future__ import annotations

import math

from zenvoy.vehicles.estimator import ReadingError


def gap_error() -> ReadingError:
    """Return a new uniform error of ±10 %. An error remembers the size of its readings."""
    return ReadingError(0.1 / math.sqrt(3), 37.5)


def speed_error() -> ReadingError:
    """Return the same for a speed, m/s."""
    return ReadingError(0.1 / math.sqrt(3), 30.0)
