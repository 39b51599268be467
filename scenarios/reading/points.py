"""Arithmetic on the points of a recording, exact until the result is rounded once."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta
from decimal import Decimal
from itertools import pairwise

from zenvoy.scenarios.schema.units import Ratio


def between(first: str | datetime, time: str | datetime) -> timedelta | None:
    """Return the time between two dates; None if one is not a date, or only one has a time zone."""
    if not (isinstance(first, datetime) and isinstance(time, datetime)):
        return None
    if (first.utcoffset() is None) != (time.utcoffset() is None):
        return None
    return time - first


def scaled(cell: str, ratio: Ratio) -> float:
    """Return a number times a ratio, rounded once."""
    if ratio[0] == ratio[1]:
        return float(cell)
    return float(Decimal(cell) * ratio[0] / ratio[1])


def longest_gap(
    read: Sequence[tuple[int, object, str | None]], lines: Sequence[int], times: Sequence[float]
) -> float:
    """Return the longest time between two points around rows without a speed, s."""
    missing = {line for line, _, speed in read if speed is None}
    if not missing:
        return 0.0
    gaps = (
        after - before
        for (line, before), (next_line, after) in pairwise(zip(lines, times, strict=True))
        if any(skipped in missing for skipped in range(line + 1, next_line))
    )
    return max(gaps, default=0.0)
