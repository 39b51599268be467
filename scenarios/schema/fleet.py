"""The vehicles of a scenario: the fleet, its groups, and how a vehicle carries out commands."""

from __future__ import annotations

from itertools import accumulate
from typing import Annotated, Literal

from pydantic import Field

from zenvoy.scenarios.schema.bumpers import BUMPER_GAP, DESIRED_BUMPER_GAP
from zenvoy.scenarios.schema.inputs import GroupName, Model, Parameters, VehicleSet
from zenvoy.values.section import LARGEST, Fraction, NonNegative, Positive, Section


class Gains(Section):
    """The gains k_d in s⁻², k_v and k_c in s⁻¹ (the paper gives no values).

    k_c pulls the speed towards the desired speed. A negative k_c drives it away, as in the paper's
    printed equations.
    """

    k_d: NonNegative = 0.1
    """Gain of the gap."""
    k_v: NonNegative = 0.5
    """Gain of the relative speed."""
    k_c: Annotated[float, Field(ge=-LARGEST, le=LARGEST)] = 0.05
    """Gain of the error of the own speed; below 0 it drives the speed away from the desired one."""


class Vehicle(Section):
    """How a vehicle carries out its commands.

    Its acceleration follows the command with a first-order lag of time constant actuator_lag_s;
    null: without lag. Commands and the accelerations that they cause stay between
    -max_deceleration_mps2 and max_acceleration_mps2; null: control.acceleration_limit_mps2.
    """

    actuator_lag_s: Annotated[float, Field(ge=0.001, le=100)] | None = None
    """Time constant with which the acceleration follows the command, a first-order lag; null: at
    once."""
    max_acceleration_mps2: Positive | None = None
    """Limit of accelerations that are commanded; null: control.acceleration_limit_mps2."""
    max_deceleration_mps2: Positive | None = None
    """The same for braking."""


class Group(Section):
    """A set of vehicles with its own settings; null: the settings of `control` and `vehicle`.

    The set is given by `vehicles`, or drawn by seed as a `share` of the fleet. If groups overlap,
    the last one counts.
    """

    model_config = DESIRED_BUMPER_GAP

    name: GroupName
    """Name for the schedule and for later groups."""
    vehicles: VehicleSet | None = None
    """Its vehicles; give this or `share`."""
    share: Fraction | None = None
    """Fraction of the fleet, drawn by seed."""
    model: Model | None = None
    """Control law; an entry of the schedule without vehicles does not change it."""
    parameters: Parameters = ()
    """Parameters of the law; see [Control laws](laws.md), or [Extending Zenvoy](extending.md) for
    your own."""
    gains: Gains | None = None
    """As control.gains."""
    desired_gap_m: Positive | None = None
    """As control.desired_gap_m."""
    desired_speed_mps: NonNegative | None = None
    """As control.desired_speed_mps."""
    vehicle: Vehicle | None = None
    """As vehicle; a key that is null there keeps the value of the fleet."""
    beacons: bool = True
    """Whether these vehicles send beacons."""


class Fleet(Section):
    """Vehicles 1..size; vehicle i follows i - 1.

    At the start they have equal gaps and equal speeds, unless the gaps of vehicles 2..size or the
    speeds of all vehicles are given.
    """

    model_config = BUMPER_GAP

    size: Annotated[int, Field(ge=2, le=10_000)] = 40
    """Number of vehicles; vehicle i follows i - 1. On the ring, a law that looks behind needs at
    least 3."""
    length_m: Positive = 5.0
    """Length of a vehicle; a smaller gap is a collision."""
    gap_m: Positive = 37.5
    """Gap at the start, from front to front; greater than the length."""
    speed_mps: NonNegative = 30.0
    """Speed at the start."""
    initial_gaps_m: Annotated[tuple[Positive, ...], Field(strict=False)] | None = None
    """Instead of even spacing: the gaps of vehicles 2 to size at the start, from front to front,
    each greater than the length; on a ring, the first vehicle has the rest."""
    initial_speeds_mps: Annotated[tuple[NonNegative, ...], Field(strict=False)] | None = None
    """Instead of one speed: the speeds of vehicles 1 to size at the start."""
    reported_gaps: Literal["front-to-front", "bumper-to-bumper"] = "front-to-front"
    """From where to where reports give gaps; bumper-to-bumper is the default of a scenario that
    gives a gap so."""
    groups: Annotated[tuple[Group, ...], Field(strict=False)] = ()  # a list is allowed, too
    """Sets of vehicles with settings of their own."""

    @property
    def gaps_at_start_m(self) -> tuple[float, ...]:
        """The gaps of vehicles 2..size at the start, m."""
        even = (self.gap_m,) * (self.size - 1)
        return even if self.initial_gaps_m is None else self.initial_gaps_m

    @property
    def positions_at_start_m(self) -> tuple[float, ...]:
        """The positions of vehicles 1..size at the start, m; the last vehicle is at 0."""
        if self.initial_gaps_m is None:
            return tuple(behind * self.gap_m for behind in range(self.size - 1, -1, -1))
        return tuple(accumulate(reversed(self.initial_gaps_m), initial=0.0))[::-1]

    @property
    def speeds_at_start_mps(self) -> tuple[float, ...]:
        """The speeds of vehicles 1..size at the start, m/s."""
        even = (self.speed_mps,) * self.size
        return even if self.initial_speeds_mps is None else self.initial_speeds_mps
