"""Derives the unit of each logged column from its field name in messages.proto."""

from __future__ import annotations

from typing import Final

from zenvoy.bus.topics import LOGGED

# The first part found in a name decides. A standard deviation has the unit of its quantity.
_BY_PART: Final = (
    ("_ns", "ns"),
    ("acceleration", "m/s²"),
    ("speed", "m/s"),
    ("gap", "m"),
    ("position", "m"),
    ("distance", "m"),
)


def unit_of(column: str) -> str:
    """Return the unit of a column: "ns", "m", …; "" for counts, vehicles, kinds and shares."""
    return next((unit for part, unit in _BY_PART if part in column), "")


UNITS: Final = {
    topic.log_name: {field.name: unit_of(field.name) for field in topic.message.DESCRIPTOR.fields}
    for topic in LOGGED
}
"""Topic -> column -> unit, for every topic of the log."""
