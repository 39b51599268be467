"""The control law of a scenario, its desired state, its timing and its schedule."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from zenvoy.scenarios.schema.bumpers import DESIRED_BUMPER_GAP
from zenvoy.scenarios.schema.fleet import Gains
from zenvoy.scenarios.schema.inputs import Model, Parameters, VehicleSet, Weights
from zenvoy.values.section import LARGEST, NonNegative, Percent, Positive, Section


class GainChanges(Section):
    """Changes of gains, as in Gains; null: unchanged."""

    k_d: NonNegative | None = None
    """Gain of the gap; null: unchanged."""
    k_v: NonNegative | None = None
    """Gain of the relative speed; null: unchanged."""
    k_c: Annotated[float, Field(ge=-LARGEST, le=LARGEST)] | None = None
    """Gain of the error of the own speed; null: unchanged."""

    @property
    def given(self) -> dict[str, float]:
        """The gains that change."""
        return self.model_dump(exclude_none=True)


class Switch(Section):
    """A change of model, desired gap, desired speed or gains from at_s on; null: unchanged.

    vehicles null: all vehicles whose groups do not set the value that changes. Gap, speed and gains
    may change linearly over ramp_s; a model changes at once.
    """

    model_config = DESIRED_BUMPER_GAP

    at_s: NonNegative
    """Time of the change."""
    vehicles: VehicleSet | None = None
    """Vehicles that change; null: all whose groups do not set the value."""
    model: Model | None = None
    """The law from then on."""
    parameters: Parameters = ()
    """Parameters of the law; see [Control laws](laws.md), or [Extending Zenvoy](extending.md) for
    your own."""
    desired_gap_m: Positive | None = None
    """As control.desired_gap_m, from then on."""
    desired_speed_mps: NonNegative | None = None
    """As control.desired_speed_mps, from then on."""
    gains: GainChanges | None = None
    """Gains k_d, k_v and k_c from then on; gains that are left out stay as they are."""
    ramp_s: NonNegative = 0.0
    """Time over which gap, speed and gains change linearly."""

    @property
    def targets(self) -> dict[str, float]:
        """The values that change, except the model: desired_gap_m, desired_speed_mps, k_d, …"""
        named = {"desired_gap_m": self.desired_gap_m, "desired_speed_mps": self.desired_speed_mps}
        given = {name: value for name, value in named.items() if value is not None}
        return given if self.gains is None else given | self.gains.given


class MultiNode(Section):
    """MBCM: the number of vehicles on each side, and their weights c_1 .. c_m, nearest first."""

    neighbours: Annotated[int, Field(ge=1, le=100)] = 3
    """Vehicles on each side that MBCM uses; fewer if the chain of beacons is shorter."""
    weights: Weights = "least-squares"
    """Weights, nearest first; least-squares: j² / Σ l², uniform: 1 / m."""


class Platoon(Section):
    """CACC: platoons of `size` consecutive vehicles (null: one platoon), led by the first.

    c1 is the weight of the leader against the vehicle ahead, xi the damping ratio and omega_n
    the bandwidth (rad/s) of Rajamani's law; the defaults are Plexe's. commanded: whether the
    accelerations fed forward are commands; reported_speed: whether the speed of the vehicle ahead
    is the one that it reports. In Plexe both are so.
    """

    size: Annotated[int, Field(ge=2, le=10_000)] | None = None
    """Vehicles in each platoon; the first leads and runs FM; null: one platoon."""
    c1: Annotated[float, Field(ge=0, lt=1), Percent] = 0.5
    """Weight of the leader relative to the vehicle ahead."""
    xi: Annotated[float, Field(ge=1, le=LARGEST)] = 1.0
    """Damping ratio."""
    omega_n: Positive = 0.2
    """Bandwidth, rad/s."""
    commanded: bool = False
    """True: accelerations fed forward are the newest commands of the others, as in Plexe; false:
    those that act."""
    reported_speed: bool = False
    """True: the speed of the vehicle ahead is the one that it reports, as in Plexe; false: by
    radar."""


class Control(Section):
    """The control law, its desired state and its timing (docs/architecture.md).

    v2v_wait_ms null: as long as the technology needs (`zenvoy.scenarios.schema.waits`).
    """

    model_config = DESIRED_BUMPER_GAP

    model: Model = "PBCM"
    """The control law, or one of your own: `mylaws:smith`."""
    parameters: Parameters = ()
    """Parameters of the law; see [Control laws](laws.md), or [Extending Zenvoy](extending.md) for
    your own."""
    schedule: Annotated[tuple[Switch, ...], Field(strict=False)] = ()  # a list is allowed, too
    """Changes of laws, gaps, speeds and gains, in order of time."""
    gains: Gains = Gains()
    """Gains of FM, BCM, MBCM and PBCM."""
    multi_node: MultiNode = MultiNode()
    """The neighbours of MBCM."""
    platoon: Platoon = Platoon()
    """Platoons, and the parameters of CACC."""
    neighbour_state: Literal["radar", "position"] = "radar"
    """Source of a link's state: the radars of the vehicle and its follower, or differences of
    reported positions."""
    desired_gap_m: Positive = 37.5
    """For laws with a constant gap, such as FM and CACC, from front to front; greater than the
    length."""
    desired_speed_mps: NonNegative = 30.0
    """Speed v_des that the laws aim at."""
    acceleration_limit_mps2: Positive = 3.0
    """Limit of commands, for acceleration and braking."""
    v2v_wait_ms: NonNegative | None = None  # in a valid scenario never None
    """How long after the start of a cycle a vehicle waits for frames; less than the period; null:
    as long as the technology needs, see below."""
    system_delay_ms: NonNegative = 89.0
    """Time from a decision to its effect."""
    beacon_age_limit_ms: Positive = 1000.0
    """Age of a neighbour's data beyond which a vehicle falls back to FM; SPBCM ignores it."""
