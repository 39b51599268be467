"""Events of single vehicles: brakes, and speed profiles that a vehicle follows.

From start_ns (included) to end_ns (excluded) an event sets the acceleration of its vehicle and
overrides the controller. A brake overrides a speed profile, and both override the return from a
brake.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag

from zenvoy.scenarios.schema.trace_options import trace_file_schema
from zenvoy.values.section import NS_PER_S, NonNegative, Positive, Section

Vehicle = Annotated[int, Field(ge=1)]
Point = Annotated[tuple[NonNegative, NonNegative], Field(strict=False)]  # time_s, speed_mps


class Lasting(Section):
    """An event that begins at at_s and lasts for duration_s."""

    type: str
    vehicle: Vehicle
    """Its vehicle, up to fleet.size."""
    at_s: NonNegative
    """When it begins."""
    duration_s: Positive
    """How long it lasts."""

    @property
    def start_ns(self) -> int:
        """When it begins."""
        return round(self.at_s * NS_PER_S)

    @property
    def end_ns(self) -> int:
        """When it ends."""
        return round((self.at_s + self.duration_s) * NS_PER_S)


class Brake(Lasting):
    """The vehicle brakes from at_s for duration_s.

    Within return_s it then returns to its earlier speed; null: it does not return.
    """

    type: Literal["brake"] = "brake"
    deceleration_mps2: Positive
    """Deceleration; of two simultaneous brakes, the harder one counts."""
    return_s: Positive | None = None
    """Time in which the vehicle returns linearly to its earlier speed; null: it does not return."""

    @property
    def returned_ns(self) -> int:
        """When the vehicle has its earlier speed again; end_ns if it does not return."""
        return round((self.at_s + self.duration_s + (self.return_s or 0.0)) * NS_PER_S)


class Sine(Lasting):
    """The speed oscillates about its mean from at_s for duration_s.

    If to_frequency_hz is given, the frequency changes linearly to it.
    """

    type: Literal["sine"] = "sine"
    mean_mps: NonNegative = 30.0
    """Mean speed."""
    amplitude_mps: NonNegative
    """Amplitude, not above the mean."""
    frequency_hz: Positive
    """Frequency, less than half the rate of the cycles (period_ms)."""
    to_frequency_hz: Positive | None = None
    """Frequency at the end, reached linearly: a linear chirp."""

    @property
    def highest_mps(self) -> float:
        """The highest speed of the profile, m/s."""
        return self.mean_mps + self.amplitude_mps


def _file_instead_of_points(schema: dict[str, Any]) -> None:
    """Allow `file`, whose contents `zenvoy.scenarios.reading.files` puts into points."""
    points = schema["properties"].pop("points")
    schema["properties"] |= {**trace_file_schema(), "points": points}
    schema["required"].remove("points")


class Trace(Section):
    """The speed follows points of (time_s, speed_mps), in order of time and relative to at_s.

    Between two points it changes linearly.
    """

    model_config = ConfigDict(json_schema_extra=_file_instead_of_points)

    type: Literal["trace"] = "trace"
    vehicle: Vehicle
    """Its vehicle, up to fleet.size."""
    at_s: NonNegative
    """Time 0 of the points."""
    points: Annotated[tuple[Point, ...], Field(strict=False)]  # a list is allowed, too
    """2 to 60000 of [time_s, speed_mps], times rising, both in [0, 1e9]."""

    @property
    def times_ns(self) -> tuple[int, ...]:
        """The times of the points, ns."""
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
        """The highest speed of the profile, m/s."""
        return max(speed_mps for _, speed_mps in self.points)

    def _instant_ns(self, index: int) -> int:
        return round(self.at_s * NS_PER_S) + round(self.points[index][0] * NS_PER_S)


def _type_of(event: object) -> str | None:
    """Return the tag of an event, given as a mapping or as one of the sections above."""
    kind = event.get("type", "brake") if isinstance(event, dict) else getattr(event, "type", None)
    return kind if isinstance(kind, str) else None


Event = Annotated[
    Annotated[Brake, Tag("brake")] | Annotated[Sine, Tag("sine")] | Annotated[Trace, Tag("trace")],
    Discriminator(_type_of),
]
