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
    k_v: NonNegative | None = None
    k_c: Annotated[float, Field(ge=-LARGEST, le=LARGEST)] | None = None

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
    vehicles: VehicleSet | None = None
    model: Model | None = None
    parameters: Parameters = ()
    desired_gap_m: Positive | None = None
    desired_speed_mps: NonNegative | None = None
    gains: GainChanges | None = None
    ramp_s: NonNegative = 0.0

    @property
    def targets(self) -> dict[str, float]:
        """The values that change, except the model: desired_gap_m, desired_speed_mps, k_d, …"""
        named = {"desired_gap_m": self.desired_gap_m, "desired_speed_mps": self.desired_speed_mps}
        given = {name: value for name, value in named.items() if value is not None}
        return given if self.gains is None else given | self.gains.given


class MultiNode(Section):
    """MBCM: the number of vehicles on each side, and their weights c_1 .. c_m, nearest first."""

    neighbours: Annotated[int, Field(ge=1, le=100)] = 3
    weights: Weights = "least-squares"


class Platoon(Section):
    """CACC: platoons of `size` consecutive vehicles (null: one platoon), led by the first.

    c1 is the weight of the leader against the vehicle ahead, xi the damping ratio and omega_n
    the bandwidth (rad/s) of Rajamani's law; the defaults are Plexe's. commanded: whether the
    accelerations fed forward are commands; reported_speed: whether the speed of the vehicle ahead
    is the one that it reports. In Plexe both are so.
    """

    size: Annotated[int, Field(ge=2, le=10_000)] | None = None
    c1: Annotated[float, Field(ge=0, lt=1), Percent] = 0.5
    xi: Annotated[float, Field(ge=1, le=LARGEST)] = 1.0
    omega_n: Positive = 0.2
    commanded: bool = False
    reported_speed: bool = False


class Control(Section):
    """The control law, its desired state and its timing (docs/architecture.md).

    v2v_wait_ms null: as long as the technology needs (`zenvoy.scenarios.schema.waits`).
    """

    model_config = DESIRED_BUMPER_GAP

    model: Model = "PBCM"
    parameters: Parameters = ()
    schedule: Annotated[tuple[Switch, ...], Field(strict=False)] = ()  # a list is allowed, too
    gains: Gains = Gains()
    multi_node: MultiNode = MultiNode()
    platoon: Platoon = Platoon()
    neighbour_state: Literal["radar", "position"] = "radar"
    desired_gap_m: Positive = 37.5
    desired_speed_mps: NonNegative = 30.0
    acceleration_limit_mps2: Positive = 3.0
    v2v_wait_ms: NonNegative | None = None  # in a valid scenario never None
    system_delay_ms: NonNegative = 89.0
    beacon_age_limit_ms: Positive = 1000.0
