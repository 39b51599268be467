"""Units of what is logged, from the names of the fields in messages.proto."""

from __future__ import annotations

from typing import Final

from zenvoy.bus.topics import LOGGED

# The first that is found in a name decides; a standard deviation has the unit of its quantity.
_BY_PART: Final = (
    ("_ns", "ns"),
    ("acceleration", "m/s²"),
    ("speed", "m/s"),
    ("gap", "m"),
    ("position", "m"),
    ("distance", "m"),
)


def unit_of(column: str) -> str:
    """Unit of a column: "ns", "m", …; "" for counts, numbers of vehicles, kinds and shares."""
    return next((unit for part, unit in _BY_PART if part in column), "")


UNITS: Final = {
    topic.log_name: {field.name: unit_of(field.name) for field in topic.message.DESCRIPTOR.fields}
    for topic in LOGGED
}
"""Topic -> column -> unit, of every topic of the log."""
