"""What happens to single vehicles: brakes, and speeds that a vehicle follows.

An event rules its vehicle's acceleration whatever the controller says, from start_ns (included)
to end_ns (excluded); before and after, the controller rules. Where a brake and a speed profile
meet, the brake wins; where the return from a brake meets either, the return gives way.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag

from zenvoy.scenarios.schema.trace_options import trace_file_schema
from zenvoy.values.section import NS_PER_S, NonNegative, Positive, Section

Vehicle = Annotated[int, Field(ge=1)]
Point = Annotated[tuple[NonNegative, NonNegative], Field(strict=False)]  # time_s, speed_mps


class Brake(Section):
    """From at_s, for duration_s, the vehicle brakes.

    Within return_s it then goes back to the speed that it had before; null: it does not.
    """

    type: Literal["brake"] = "brake"
    vehicle: Vehicle
    at_s: NonNegative
    duration_s: Positive
    deceleration_mps2: Positive
    return_s: Positive | None = None

    @property
    def start_ns(self) -> int:
        """When it begins."""
        return round(self.at_s * NS_PER_S)

    @property
    def end_ns(self) -> int:
        """When it ends."""
        return round((self.at_s + self.duration_s) * NS_PER_S)

    @property
    def returned_ns(self) -> int:
        """When the vehicle has the speed again that it had before; end_ns if it does not return."""
        return round((self.at_s + self.duration_s + (self.return_s or 0.0)) * NS_PER_S)


class Sine(Section):
    """From at_s, for duration_s, the speed swings about its mean.

    The frequency rises (or falls) evenly to to_frequency_hz, where there is one.
    """

    type: Literal["sine"] = "sine"
    vehicle: Vehicle
    at_s: NonNegative
    duration_s: Positive
    mean_mps: NonNegative = 30.0
    amplitude_mps: NonNegative
    frequency_hz: Positive
    to_frequency_hz: Positive | None = None

    @property
    def start_ns(self) -> int:
        """When it begins."""
        return round(self.at_s * NS_PER_S)

    @property
    def end_ns(self) -> int:
        """When it ends."""
        return round((self.at_s + self.duration_s) * NS_PER_S)

    @property
    def highest_mps(self) -> float:
        """The highest speed within, m/s."""
        return self.mean_mps + self.amplitude_mps


def _file_instead_of_points(schema: dict[str, Any]) -> None:
    """Allow `file`, whose contents `zenvoy.scenarios.reading.files` puts into points."""
    points = schema["properties"].pop("points")
    schema["properties"] |= {**trace_file_schema(), "points": points}
    schema["required"].remove("points")


class Trace(Section):
    """From at_s + the first time to at_s + the last, the speed runs from point to point.

    Points are (time_s, speed_mps), in order of time.
    """

    model_config = ConfigDict(json_schema_extra=_file_instead_of_points)

    type: Literal["trace"] = "trace"
    vehicle: Vehicle
    at_s: NonNegative
    points: Annotated[tuple[Point, ...], Field(strict=False)]  # a list is welcome too

    @property
    def times_ns(self) -> tuple[int, ...]:
        """Instants of the points."""
        start_ns = round(self.at_s * NS_PER_S)
        return tuple(start_ns + round(time_s * NS_PER_S) for time_s, _ in self.points)

    @property
    def start_ns(self) -> int:
        """When it begins: at the first point."""
        return self._instant_ns(0)

    @property
    def end_ns(self) -> int:
        """When it ends: at the last point."""
        return self._instant_ns(-1)

    @property
    def highest_mps(self) -> float:
        """The highest speed within, m/s."""
        return max(speed_mps for _, speed_mps in self.points)

    def _instant_ns(self, index: int) -> int:
        return round(self.at_s * NS_PER_S) + round(self.points[index][0] * NS_PER_S)


def _type_of(event: object) -> str | None:
    """The tag of an event, given as a mapping or as one of the sections above."""
    kind = event.get("type", "brake") if isinstance(event, dict) else getattr(event, "type", None)
    return kind if isinstance(kind, str) else None


Event = Annotated[
    Annotated[Brake, Tag("brake")] | Annotated[Sine, Tag("sine")] | Annotated[Trace, Tag("trace")],
    Discriminator(_type_of),
]
