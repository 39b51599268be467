"""A V2V technology: a column of the paper's Table I, or a user's own."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field, PlainSerializer, PlainValidator

from zenvoy.scenarios.schema.inputs import written_as
from zenvoy.values.section import LARGEST, Positive, Section


def _span(value: object) -> tuple[float, float]:
    """Return 10 as (10, 10) and [20, 80] as (20, 80)."""
    bounds = value if isinstance(value, list | tuple) else (value, value)
    if len(bounds) != 2 or not all(map(_is_bound, bounds)) or bounds[0] > bounds[1]:
        raise ValueError
    return float(bounds[0]), float(bounds[1])


def _is_bound(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= LARGEST


_BOUND: Final = {"type": "number", "minimum": 0, "maximum": LARGEST}
Span = Annotated[
    tuple[float, float],
    PlainValidator(_span),
    PlainSerializer(list),
    written_as(
        "a number in [0, 1e9], or a list of two such numbers in ascending order",
        _BOUND,
        {"type": "array", "items": _BOUND, "minItems": 2, "maxItems": 2},
    ),
]
Label = Annotated[
    str,
    Field(pattern=r"^[^\x00-\x1f\x7f-\x9f]{1,100}$"),
    written_as(
        "text of 1 to 100 characters in one line",
        {"type": "string", "minLength": 1, "maxLength": 100},
    ),
]
BitRate = Annotated[float, Field(ge=0.001, le=LARGEST)]


class Technology(Section):
    """A V2V technology.

    title, band_ghz, bandwidth, bit_rate, v2v and mimo are shown in tables only. The latency of a
    frame is delay_ms, drawn uniformly from a span, plus its time on the air at bit_rate_mbps.
    Without broadcast a sender sends a copy to each neighbour, one after the other. csma says
    whether carrier sense of IEEE 802.11 (`channel.medium.access: csma`) is allowed.
    """

    name: Label
    """Name in reports and messages."""
    title: Label | None = None
    """Name in tables; null: `name`."""
    band_ghz: Span | None = None
    """For tables."""
    bandwidth: Label | None = None
    """For tables."""
    range_m: Positive
    """Longest distance at which a frame is received."""
    bit_rate: Label | None = None
    """For tables, such as "3 to 27 Mbit/s"."""
    bit_rate_mbps: BitRate
    """Determines the time of a frame on the air."""
    delay_ms: Span
    """Latency besides the time on the air; drawn uniformly between two numbers."""
    broadcast: bool
    """False: each neighbour gets its own copy, one after the other."""
    csma: bool = False
    """Whether `medium.access: csma` is allowed."""
    v2v: bool = True
    """For tables."""
    mimo: bool = True
    """For tables."""
