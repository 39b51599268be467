"""What a scenario may say of the channel: its technology, and what goes wrong on the way."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from zenvoy.scenarios.inputs import VehicleSet
from zenvoy.scenarios.section import LARGEST, Fraction, NonNegative, Positive, Section

TechnologyName = Literal["ieee80211p", "ieee80211px", "lte-a-pro", "5g-mmwave"]
Along = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]


class GilbertElliott(Section):
    """Loss in bursts, as Linux `tc netem … loss gemodel p [r [1-h [1-k]]]` has it, as fractions.

    p: from the good state to the bad one; r: back (null: 1 - p). A frame is lost with one_minus_h
    in the bad state and with one_minus_k in the good one.
    """

    p: Fraction = 0.0
    r: Fraction | None = None
    one_minus_h: Fraction = 1.0
    one_minus_k: Fraction = 0.0


class FourState(Section):
    """Loss as `tc netem … loss state p13 [p31 [p32 [p23 [p14]]]]` has it, as fractions.

    States: 1 received in a gap, 2 received in a burst, 3 lost in a burst, 4 lost in a gap. p31
    null: 1 - p13.
    """

    p13: Fraction = 0.0
    p31: Fraction | None = None
    p32: Fraction = 0.0
    p23: Fraction = 1.0
    p14: Fraction = 0.0


class Loss(Section):
    """What a receiver misses: a frame is lost if any of these says so, each link for itself."""

    p: Fraction = 0.0
    gilbert_elliott: GilbertElliott = GilbertElliott()
    four_state: FourState = FourState()


class Scope(Section):
    """From from_s (included) to until_s (excluded), for frames of these links and this stretch.

    until_s null: to the end; source, destination null: any vehicle. Only where sender or receiver
    is between from_m and to_m along the road (null: unbounded). Positions on the ring count from
    0 to its length, and from_m may be greater than to_m there: the stretch goes over the seam.
    """

    from_s: NonNegative = 0.0
    until_s: Positive | None = None
    source: VehicleSet | None = None
    destination: VehicleSet | None = None
    from_m: Along | None = None
    to_m: Along | None = None


class Outage(Scope):
    """Every frame is lost there and then."""


class Channel(Section):
    """The V2X technology (paper Table I) and what goes wrong on the way."""

    technology: TechnologyName = "ieee80211p"
    loss: Loss = Loss()
    outages: Annotated[tuple[Outage, ...], Field(strict=False)] = ()  # a list is welcome too
    frame_bytes: Annotated[int, Field(ge=1, le=65_535)] = 300
    bit_rate_mbps: Annotated[float, Field(ge=0.001, le=LARGEST)] | None = None  # None: Table I's
