"""Units of time and speed, and their spellings in the headers of tables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from decimal import Decimal
from types import MappingProxyType
from typing import Final

# Multiply a value in the unit by the first number and divide by the second to get m/s or s.
Ratio = tuple[Decimal, Decimal]

SPEEDS: Final[Mapping[str, Ratio]] = MappingProxyType(
    {
        "m/s": (Decimal(1), Decimal(1)),
        "km/h": (Decimal(1), Decimal("3.6")),
        "mph": (Decimal("0.44704"), Decimal(1)),
        "knots": (Decimal(1852), Decimal(3600)),
    }
)
TIMES: Final[Mapping[str, Ratio]] = MappingProxyType(
    {
        "s": (Decimal(1), Decimal(1)),
        "ms": (Decimal(1), Decimal(1_000)),
        "us": (Decimal(1), Decimal(1_000_000)),
        "ns": (Decimal(1), Decimal(1_000_000_000)),
        "min": (Decimal(60), Decimal(1)),
    }
)
_SPELLINGS: Final = {
    "m/s": ("mps", "m/sec", "m_s", "ms-1", "m s-1", "m*s^-1", "meters/second"),
    "km/h": ("kmh", "kph", "kmph", "km/hr", "km_h", "kmh-1", "km h-1"),
    "mph": ("mi/h", "miles/h", "mile/h", "mi_h"),
    "knots": ("knot", "kn", "kt", "kts"),
    "s": ("sec", "secs", "second", "seconds"),
    "ms": ("msec", "millis", "millisecond", "milliseconds"),
    "us": ("µs", "μs", "usec", "microsecond", "microseconds"),
    "ns": ("nsec", "nanosecond", "nanoseconds"),
    "min": ("minute", "minutes"),
}
_BRACKETS: Final = re.compile(r"(.*?)[\s_]*[\[(]([^\[\]()]*)[\])]\s*")
_CAMEL: Final = re.compile(r"(?<=[a-z])(?=[A-Z])")


def unit_named(text: str, units: Iterable[str]) -> str | None:
    """Return the unit that `text` spells, in brackets or not; None if it is not one of `units`."""
    spelling = text.strip().strip("[]()").strip().lower()
    return next((unit for unit in units if spelling in (unit, *_SPELLINGS[unit])), None)


def split_header(cell: str, units: Iterable[str]) -> tuple[str, str | None]:
    """Return the name and unit of a column such as "Speed [km/h]", "speed_kmh" or "cycMps".

    The name is in lower case; the unit is one of `units`, or None if the cell names none.
    """
    units = tuple(units)
    bracketed = _BRACKETS.fullmatch(cell.strip())
    if bracketed is not None:
        unit = unit_named(bracketed[2], units)
        if unit is not None:
            return bracketed[1].strip().lower(), unit
    text = _CAMEL.sub("_", cell.strip()).lower()
    spellings = [(text, unit) for unit in units for text in (unit, *_SPELLINGS[unit])]
    for spelling, unit in sorted(spellings, key=lambda spelled: -len(spelled[0])):
        if text == spelling and len(spelling) > 1:
            return "", unit
        found = re.fullmatch(rf"(.+?)[\s_,;:./-]+{re.escape(spelling)}", text)
        if found is not None:
            return found[1], unit
    return text, None
