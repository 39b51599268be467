"""What a scenario may say of the channel: its technology, and what goes wrong on the way."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from zenvoy.scenarios.section import LARGEST, Fraction, Section

TechnologyName = Literal["ieee80211p", "ieee80211px", "lte-a-pro", "5g-mmwave"]


class Loss(Section):
    """Independent loss: each frame is lost at each receiver with probability p."""

    p: Fraction = 0.0


class Channel(Section):
    """The V2X technology (paper Table I) and what goes wrong on the way."""

    technology: TechnologyName = "ieee80211p"
    loss: Loss = Loss()
    frame_bytes: Annotated[int, Field(ge=1, le=65_535)] = 300
    bit_rate_mbps: Annotated[float, Field(ge=0.001, le=LARGEST)] | None = None  # None: Table I's
