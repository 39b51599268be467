"""The section `channel` of a scenario: technology, latency, loss and medium."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, create_model
from pydantic.json_schema import WithJsonSchema

from zenvoy.links.table import distributions, loss_models
from zenvoy.scenarios.schema.inputs import VehicleSet
from zenvoy.scenarios.schema.technologies import (
    DEFAULT,
    default_technology,
    technologies,
    technology_named,
)
from zenvoy.scenarios.schema.technology import BitRate, Label, Span, Technology
from zenvoy.values.section import LARGEST, Fraction, NonNegative, Positive, Section

Messages = Annotated[int, Field(ge=1, le=10_000)]
Along = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
_WIDTH: Final = 92  # characters per line in the description of a section


def _loss_section() -> type[Section]:
    """Return the section `loss`, with a key for each loss model."""
    text = "A receiver misses a frame if any of these models says so. Links are independent."
    keys: dict[str, Any] = {
        model.key: (model.value, Field(model.default, description=model.meaning))
        for model in loss_models().values()
    }
    return create_model("Loss", __base__=Section, __module__=__name__, __doc__=text, **keys)


if TYPE_CHECKING:

    class Loss(Section):
        """The loss of frames; its keys are those of `zenvoy.links.table.loss_models`."""

        def __init__(self, **values: Any) -> None: ...
        def __getattr__(self, key: str) -> Any: ...
else:
    Loss = _loss_section()


def _of_latency(schema: dict[str, Any]) -> None:
    """Describe each distribution, and allow the key `file`.

    `zenvoy.scenarios.reading.files` puts the contents of `file` into samples_ms.
    """
    text = "; ".join(f"{one.name}: {one.meaning}" for one in distributions().values())
    text = fill(f"{text}. Moments are those before it is cut off.", _WIDTH)
    schema["description"] += f"\n\n{text}"
    schema["properties"] |= {
        "file": {
            "type": "string",
            "description": "A CSV file with the header `latency_ms`, instead of samples_ms.",
        }
    }


def _known(name: str) -> str:
    if name not in distributions():
        raise ValueError
    return name


Distribution = Annotated[
    str,
    AfterValidator(_known),
    WithJsonSchema({"type": "string", "enum": list(distributions())}),
]


class SenderOffset(Section):
    """A latency up to max_ms that a sender keeps for a number of messages, as in C-V2X mode 4.

    After from_messages to to_messages messages it draws a new one, or keeps the old one with
    probability keep.
    """

    max_ms: NonNegative = 0.0
    """A sender's offset is uniform from 0 to this, beside the latency of each frame."""
    from_messages: Messages = 5
    """Least number of messages for which an offset is held."""
    to_messages: Messages = 15
    """Largest number of messages, each number as likely."""
    keep: Fraction = 0.0
    """Probability of keeping the offset then."""


class Latency(Section):
    """The latency from sender to receiver, drawn for each frame, besides its time on the air."""

    model_config = ConfigDict(json_schema_extra=_of_latency)

    distribution: Distribution = "technology"
    """Distribution of the latency; `technology`: its `delay_ms`."""
    mean_ms: NonNegative | None = None
    """Mean, for fixed, normal, gamma and pareto."""
    std_ms: Positive | None = None
    """Standard deviation, for normal and gamma."""
    min_ms: NonNegative | None = None
    """Shortest latency, for uniform, normal, gamma (null: 0) and pareto."""
    max_ms: Positive | None = None
    """Longest latency, for uniform; the others are cut off there."""
    samples_ms: Annotated[tuple[NonNegative, ...], Field(strict=False)] = ()
    """For samples: any of them, each as likely."""
    sender_offset: SenderOffset = SenderOffset()
    """A latency that a sender keeps for some messages."""
    reorder: bool = True
    """Whether a frame may overtake an earlier one of its link."""


class Scope(Section):
    """The frames that a rule or an outage covers.

    It covers the time from from_s (included) to until_s (excluded; null: to the end), and links
    from source to destination (null: any vehicle). The sender or the receiver must be between
    from_m and to_m along the road (null: unbounded). Positions on the ring go from 0 to its length;
    there from_m may be greater than to_m, and the stretch includes position 0.
    """

    from_s: NonNegative = 0.0
    """When it begins."""
    until_s: Positive | None = None
    """When it ends; null: with the run."""
    source: VehicleSet | None = None
    """Senders; null: all."""
    destination: VehicleSet | None = None
    """Receivers; null: all."""
    from_m: Along | None = None
    """Where the stretch begins; null: unbounded."""
    to_m: Along | None = None
    """Where it ends; null: unbounded."""


class Outage(Scope):
    """An outage: the frames that it covers are lost."""


class Rule(Scope):
    """A rule, whose loss or latency (null: unchanged) replaces the channel's for its frames.

    If several rules cover a frame, the last one counts.
    """

    loss: Loss | None = None
    """As `channel.loss`; null: as the channel."""
    latency: Latency | None = None
    """As `channel.latency`; null: as the channel."""


class Medium(Section):
    """How stations share the medium.

    access none: no frame waits for another or disturbs it. access csma: carrier sense as in IEEE
    802.11p, with times on the air from its symbols. carrier_sense_m is how far a transmission is
    sensed and disturbs others (null: the range of the technology). congestion_control reactive:
    ETSI TS 102 687, by the busy ratio.
    """

    access: Literal["none", "csma"] = "none"
    """`csma`: carrier sense, for a technology with `csma: true`."""
    aifsn: Annotated[int, Field(ge=2, le=15)] = 6
    """Slots of the arbitration inter-frame space."""
    contention_window: Annotated[int, Field(ge=0, le=1023)] = 15
    """Largest number of backoff slots."""
    carrier_sense_m: Positive | None = None
    """Distance at which a frame is sensed and disturbs others; null: the technology's range."""
    congestion_control: Literal["none", "reactive"] = "none"
    """`reactive`: fewer frames when the medium is busy."""


_FILE: Final = {"type": "string", "pattern": "[./]"}


def _named_too(schema: dict[str, Any]) -> None:
    """Describe what a scenario may write instead of the mapping: a name or a file name."""
    schema["default"] = DEFAULT
    schema["noun"] = f"one of {', '.join(technologies())}, a file such as ./mine.yaml, or a mapping"
    schema["forms"] = [{"enum": list(technologies())}, _FILE]


Radio = Annotated[
    Technology, BeforeValidator(technology_named), Field(json_schema_extra=_named_too)
]


class Channel(Section):
    """The V2V technology (paper Table I), its latency, loss and medium.

    title to mimo replace values of the technology (null: unchanged). relay_hops is the number of
    links that a frame may take; vehicles forward the frames of others.
    """

    technology: Radio = default_technology()
    """See `zenvoy technologies`; a file is found beside the scenario that names it."""
    title: Label | None = None
    """Instead of that of the technology; null: unchanged."""
    band_ghz: Span | None = None
    """Instead of that of the technology; null: unchanged."""
    bandwidth: Label | None = None
    """Instead of that of the technology; null: unchanged."""
    range_m: Positive | None = None
    """Instead of that of the technology; null: unchanged."""
    bit_rate: Label | None = None
    """Instead of that of the technology; null: unchanged."""
    bit_rate_mbps: BitRate | None = None
    """Instead of that of the technology; null: unchanged."""
    delay_ms: Span | None = None
    """Instead of that of the technology; null: unchanged."""
    broadcast: bool | None = None
    """Instead of that of the technology; null: unchanged."""
    csma: bool | None = None
    """Instead of that of the technology; null: unchanged."""
    v2v: bool | None = None
    """Instead of that of the technology; null: unchanged."""
    mimo: bool | None = None
    """Instead of that of the technology; null: unchanged."""
    latency: Latency = Latency()
    """From sender to receiver, besides the time on the air."""
    loss: Loss = Loss()
    """Which frames a receiver misses."""
    medium: Medium = Medium()
    """How stations share the medium."""
    relay_hops: Annotated[int, Field(ge=1, le=100)] = 1
    """Links that a frame may take; 1: vehicles do not forward frames."""
    duplicate: Fraction = 0.0
    """Probability that a received frame arrives a second time."""
    rules: Annotated[tuple[Rule, ...], Field(strict=False)] = ()  # a list is allowed, too
    """Other loss or latency for some links, times and stretches of road."""
    outages: Annotated[tuple[Outage, ...], Field(strict=False)] = ()  # a list is allowed, too
    """Times, links and stretches of road where every frame is lost."""
    frame_bytes: Annotated[int, Field(ge=1, le=65_535)] = 300
    """Size of a frame on the air."""

    @property
    def radio(self) -> Technology:
        """The technology, with the values that this section replaces."""
        given = {name: getattr(self, name) for name in Technology.model_fields if name != "name"}
        changes = {name: value for name, value in given.items() if value is not None}
        return self.technology.model_copy(update=changes)
