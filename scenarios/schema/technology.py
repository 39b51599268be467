"""A V2V technology: a column of the paper's Table I, or one of a user's own."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, PlainSerializer, PlainValidator, WithJsonSchema

from zenvoy.values.section import LARGEST, Positive, Section


def _span(value: object) -> tuple[float, float]:
    """10 as (10, 10), [20, 80] as (20, 80)."""
    bounds = value if isinstance(value, list | tuple) else (value, value)
    if len(bounds) != 2 or not all(map(_is_bound, bounds)) or bounds[0] > bounds[1]:
        raise ValueError
    return float(bounds[0]), float(bounds[1])


def _is_bound(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= LARGEST


Span = Annotated[
    tuple[float, float],
    PlainValidator(_span),
    PlainSerializer(list),
    WithJsonSchema(
        {
            "type": "string",
            "noun": "a number in [0, 1e9], or a list of two that do not fall, from and to",
        }
    ),
]
Label = Annotated[
    str,
    Field(pattern=r"^[^\x00-\x1f\x7f-\x9f]{1,100}$"),
    WithJsonSchema({"type": "string", "noun": "text of 1 to 100 characters in one line"}),
]
BitRate = Annotated[float, Field(ge=0.001, le=LARGEST)]


class Technology(Section):
    """A V2V technology.

    title, band_ghz, bandwidth, bit_rate, v2v and mimo are words for tables. A frame takes
    delay_ms, drawn evenly from a span, and its bits at bit_rate_mbps. Without broadcast a sender
    sends each neighbour a copy, one after the other. csma: whether carrier sense of IEEE 802.11
    (`channel.medium.access: csma`) may be laid over it.
    """

    name: Label
    title: Label | None = None
    band_ghz: Span | None = None
    bandwidth: Label | None = None
    range_m: Positive
    bit_rate: Label | None = None
    bit_rate_mbps: BitRate
    delay_ms: Span
    broadcast: bool
    csma: bool = False
    v2v: bool = True
    mimo: bool = True
