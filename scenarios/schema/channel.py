"""What a scenario may say of the channel: its technology, and what goes wrong on the way."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from zenvoy.scenarios.schema.inputs import VehicleSet
from zenvoy.scenarios.schema.section import LARGEST, Fraction, NonNegative, Positive, Section
from zenvoy.scenarios.schema.technologies import (
    DEFAULT,
    default_technology,
    technologies,
    technology_named,
)
from zenvoy.scenarios.schema.technology import BitRate, Label, Span, Technology

Distribution = Literal["technology", "fixed", "uniform", "normal", "gamma", "pareto", "samples"]
Messages = Annotated[int, Field(ge=1, le=10_000)]
DistanceLoss = Annotated[tuple[NonNegative, Fraction], Field(strict=False)]
Decibels = Annotated[float, Field(ge=-1000, le=1000)]
Exponent = Annotated[float, Field(ge=0, le=10)]
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


class PathLoss(Section):
    """Loss from received power: two-slope path loss, shadowing, vehicles in the way, fading.

    A frame is lost where the power is below sensitivity_dbm. reference_loss_db is that at 10 m;
    from there exponent, beyond break_m exponent_beyond. shadowing_db: standard deviation, which
    falls to 1/e of its correlation after decorrelation_m. blockage_db for each vehicle between.
    fading_m: shape of Nakagami fading, anew for each frame (1: Rayleigh); null: none.
    """

    transmit_dbm: Decibels = 23.0
    sensitivity_dbm: Decibels = -88.0
    reference_loss_db: Decibels = 66.1
    exponent: Exponent = 1.66
    break_m: Annotated[float, Field(ge=10, le=LARGEST)] = 104.0
    exponent_beyond: Exponent = 2.88
    shadowing_db: Annotated[float, Field(ge=0, le=100)] = 3.95
    decorrelation_m: Positive = 25.0
    blockage_db: Annotated[float, Field(ge=0, le=1000)] = 9.0
    fading_m: Annotated[float, Field(ge=0.5, le=1000)] | None = None


class Loss(Section):
    """What a receiver misses: a frame is lost if any of these says so, each link for itself.

    path_loss null: power is no matter. by_distance: (distance_m, probability) in order of
    distance, straight lines between them, and as at the nearest of them beyond. corrupt: the
    probability that a frame arrives damaged; the receiver drops it.
    """

    p: Fraction = 0.0
    path_loss: PathLoss | None = None
    by_distance: Annotated[tuple[DistanceLoss, ...], Field(strict=False)] = ()  # a list is fine too
    corrupt: Fraction = 0.0
    gilbert_elliott: GilbertElliott = GilbertElliott()
    four_state: FourState = FourState()


def _file_instead_of_samples(schema: dict[str, Any]) -> None:
    """Allow `file`, whose contents `zenvoy.scenarios.reading.files` puts into samples_ms."""
    schema["properties"] |= {"file": {"type": "string"}}


class SenderOffset(Section):
    """A latency up to max_ms that a sender keeps for a number of messages, as C-V2X mode 4 does.

    After from_messages to to_messages of them it draws a new one, or keeps the old one with
    probability keep.
    """

    max_ms: NonNegative = 0.0
    from_messages: Messages = 5
    to_messages: Messages = 15
    keep: Fraction = 0.0


class Latency(Section):
    """From sender to receiver, beside the frame's time on the air, each frame for itself.

    technology: as in Table I; fixed: mean_ms; uniform: min_ms to max_ms; normal: mean_ms and
    std_ms, cut off at min_ms (null: 0) and max_ms; gamma: min_ms (null: 0) and a gamma
    distribution above it with that mean and standard deviation; pareto: scale min_ms, mean_ms;
    samples: any of samples_ms. Moments are those before it is cut off.
    """

    model_config = ConfigDict(json_schema_extra=_file_instead_of_samples)

    distribution: Distribution = "technology"
    mean_ms: NonNegative | None = None
    std_ms: Positive | None = None
    min_ms: NonNegative | None = None
    max_ms: Positive | None = None
    samples_ms: Annotated[tuple[NonNegative, ...], Field(strict=False)] = ()
    sender_offset: SenderOffset = SenderOffset()
    reorder: bool = True


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


class Rule(Scope):
    """What it says of loss or latency (null: nothing) replaces what the channel says.

    Of several that apply to a frame, the last one counts.
    """

    loss: Loss | None = None
    latency: Latency | None = None


class Medium(Section):
    """How stations share the medium. access none: no frame waits for another, or disturbs it.

    csma: carrier sense as in IEEE 802.11p, with times on the air by its symbols. carrier_sense_m:
    how far a transmission is sensed, and disturbs (null: the range of the technology).
    congestion_control reactive: ETSI TS 102 687, by the busy ratio.
    """

    access: Literal["none", "csma"] = "none"
    aifsn: Annotated[int, Field(ge=2, le=15)] = 6
    contention_window: Annotated[int, Field(ge=0, le=1023)] = 15
    carrier_sense_m: Positive | None = None
    congestion_control: Literal["none", "reactive"] = "none"


def _named_too(schema: dict[str, Any]) -> None:
    """What only a file may write in place of the mapping: a name, or the name of a file."""
    schema["default"] = DEFAULT
    schema["noun"] = f"one of {', '.join(technologies())}, a file such as ./mine.yaml, or a mapping"


Radio = Annotated[
    Technology, BeforeValidator(technology_named), Field(json_schema_extra=_named_too)
]


class Channel(Section):
    """The V2V technology (paper Table I) and what goes wrong on the way.

    title to mimo replace what the technology says (null: nothing). relay_hops: links that a frame
    may go over; vehicles pass on what they hear from others.
    """

    technology: Radio = default_technology()
    title: Label | None = None
    band_ghz: Span | None = None
    bandwidth: Label | None = None
    range_m: Positive | None = None
    bit_rate: Label | None = None
    bit_rate_mbps: BitRate | None = None
    delay_ms: Span | None = None
    broadcast: bool | None = None
    csma: bool | None = None
    v2v: bool | None = None
    mimo: bool | None = None
    latency: Latency = Latency()
    loss: Loss = Loss()
    medium: Medium = Medium()
    relay_hops: Annotated[int, Field(ge=1, le=100)] = 1
    duplicate: Fraction = 0.0
    rules: Annotated[tuple[Rule, ...], Field(strict=False)] = ()  # a list is welcome too
    outages: Annotated[tuple[Outage, ...], Field(strict=False)] = ()  # a list is welcome too
    frame_bytes: Annotated[int, Field(ge=1, le=65_535)] = 300

    @property
    def radio(self) -> Technology:
        """The technology with the values that this section says instead."""
        said = {name: getattr(self, name) for name in Technology.model_fields if name != "name"}
        changes = {name: value for name, value in said.items() if value is not None}
        return self.technology.model_copy(update=changes)
