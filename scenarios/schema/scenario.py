"""The sections of a scenario: frozen, typed, with units in the names.

Every field has a default, so that a scenario file contains only differences from the paper's
setting (40 vehicles on a ring of 1500 m, Table IV). docs/decisions.md explains the defaults that
the paper does not give.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import accumulate
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, model_validator

from zenvoy.scenarios.schema.agreement import refuse_disagreements
from zenvoy.scenarios.schema.channel import Channel
from zenvoy.scenarios.schema.events import Brake, Event, Sine, Trace
from zenvoy.scenarios.schema.inputs import (
    EstimatorKind,
    GroupName,
    Model,
    Parameters,
    VehicleSet,
    Weights,
)
from zenvoy.scenarios.schema.waits import own_wait_ms
from zenvoy.values.section import (
    LARGEST,
    NS_PER_MS,
    NS_PER_S,
    Fraction,
    NonNegative,
    Percent,
    Positive,
    Section,
)


def _bumper_schema() -> dict[str, Any]:
    """Return the JSON schema of a spacing from bumper to bumper."""
    return {"type": "number", "exclusiveMinimum": 0, "maximum": LARGEST}


def _bumper(front: str, bumper: str) -> Callable[[dict[str, Any]], None]:
    """Also allow the key `bumper`, which `zenvoy.scenarios.reading.spacing` turns into `front`."""

    def add(schema: dict[str, Any]) -> None:
        properties = schema["properties"]
        keys = list(properties)
        keys.insert(keys.index(front) + 1, bumper)
        schema["properties"] = {key: properties.get(key, _bumper_schema()) for key in keys}

    return add


_BUMPER_GAP = ConfigDict(json_schema_extra=_bumper("gap_m", "bumper_gap_m"))
_DESIRED_BUMPER_GAP = ConfigDict(json_schema_extra=_bumper("desired_gap_m", "desired_bumper_gap_m"))


class Road(Section):
    """The shape of the road. The length of a ring is fleet.size · fleet.gap_m."""

    type: Literal["ring", "open"] = "ring"


class Gains(Section):
    """The gains k_d in s⁻², k_v and k_c in s⁻¹ (the paper gives no values).

    k_c pulls the speed towards the desired speed. A negative k_c drives it away, as in the paper's
    printed equations.
    """

    k_d: NonNegative = 0.1
    k_v: NonNegative = 0.5
    k_c: Annotated[float, Field(ge=-LARGEST, le=LARGEST)] = 0.05


class Vehicle(Section):
    """How a vehicle carries out its commands.

    Its acceleration follows the command with a first-order lag of time constant actuator_lag_s;
    null: without lag. Commands and the accelerations that they cause stay between
    -max_deceleration_mps2 and max_acceleration_mps2; null: control.acceleration_limit_mps2.
    """

    actuator_lag_s: Annotated[float, Field(ge=0.001, le=100)] | None = None
    max_acceleration_mps2: Positive | None = None
    max_deceleration_mps2: Positive | None = None


class Group(Section):
    """A set of vehicles with its own settings; null: the settings of `control` and `vehicle`.

    The set is given by `vehicles`, or drawn by seed as a `share` of the fleet. If groups overlap,
    the last one counts.
    """

    model_config = _DESIRED_BUMPER_GAP

    name: GroupName
    vehicles: VehicleSet | None = None
    share: Fraction | None = None
    model: Model | None = None
    parameters: Parameters = ()
    gains: Gains | None = None
    desired_gap_m: Positive | None = None
    desired_speed_mps: NonNegative | None = None
    vehicle: Vehicle | None = None
    beacons: bool = True


class Fleet(Section):
    """Vehicles 1..size; vehicle i follows i - 1.

    At the start they have equal gaps and equal speeds, unless the gaps of vehicles 2..size or the
    speeds of all vehicles are given.
    """

    model_config = _BUMPER_GAP

    size: Annotated[int, Field(ge=2, le=10_000)] = 40
    length_m: Positive = 5.0
    gap_m: Positive = 37.5
    speed_mps: NonNegative = 30.0
    initial_gaps_m: Annotated[tuple[Positive, ...], Field(strict=False)] | None = None
    initial_speeds_mps: Annotated[tuple[NonNegative, ...], Field(strict=False)] | None = None
    reported_gaps: Literal["front-to-front", "bumper-to-bumper"] = "front-to-front"
    groups: Annotated[tuple[Group, ...], Field(strict=False)] = ()  # a list is allowed, too

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

    model_config = _DESIRED_BUMPER_GAP

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
    the bandwidth (rad/s) of Rajamani's law; the defaults are Plexe's.
    """

    size: Annotated[int, Field(ge=2, le=10_000)] | None = None
    c1: Annotated[float, Field(ge=0, lt=1), Percent] = 0.5
    xi: Annotated[float, Field(ge=1, le=LARGEST)] = 1.0
    omega_n: Positive = 0.2


class Control(Section):
    """The control law, its desired state and its timing (docs/architecture.md).

    v2v_wait_ms null: as long as the technology needs (`zenvoy.scenarios.schema.waits`).
    """

    model_config = _DESIRED_BUMPER_GAP

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


class Sensors(Section):
    """Sensor errors: readings of gaps and absolute speeds are multiplied by 1 + e, |e| ≤ error."""

    error: Annotated[float, Field(ge=0, lt=1), Percent] = 0.1
    distribution: Literal["uniform", "gaussian"] = "uniform"
    position_std_m: NonNegative = 0.0

    @property
    def error_std(self) -> float:
        """The standard deviation of the error as a fraction, the same for both distributions."""
        return self.error / 3**0.5


class Estimator(Section):
    """The filters of links and own speed; acceleration_std_mps2 sets their process noise.

    On these linear models ekf and ukf agree with kalman to rounding; docs/estimators.md compares.
    """

    kind: EstimatorKind = "kalman"
    parameters: Parameters = ()
    acceleration_std_mps2: Positive = 0.5


class Beacons(Section):
    """When vehicles send beacons: in every cycle, in every n-th cycle (in turn), or like CAMs.

    period_ms is a beacon period of its own, a multiple of the control period; null: every cycle.
    All vehicles send at the same time, or in turn if they are staggered. etsi-cam follows ETSI EN
    302 637-2: after 4 m or 0.5 m/s, 100 to 1000 ms apart.
    """

    rule: Literal["every-cycle", "every-nth", "etsi-cam"] = "every-cycle"
    every: Annotated[int, Field(ge=1, le=1000)] = 1
    period_ms: Annotated[float, Field(ge=1, le=1_000_000)] | None = None
    staggered: bool = False


def _extends_in_front(schema: dict[str, Any]) -> None:
    """Allow `extends`: `zenvoy.scenarios.reading.extends` merges in the file that it names."""
    schema["properties"] = {"extends": {"type": "string"}, **schema["properties"]}


class Scenario(Section):
    """A whole experiment."""

    model_config = ConfigDict(json_schema_extra=_extends_in_front)

    description: str = ""
    duration_s: Positive = 500.0
    period_ms: Annotated[float, Field(ge=1, le=10_000)] = 100.0
    clock: Literal["lock-step", "realtime"] = "lock-step"
    speed: Annotated[float, Field(ge=0.1, le=10)] = 1.0
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    stall_limit_s: Positive = 10.0
    on_collision: Literal["continue", "stop"] = "continue"
    road: Road = Road()
    fleet: Fleet = Fleet()
    vehicle: Vehicle = Vehicle()
    control: Control = Control()
    beacons: Beacons = Beacons()
    sensors: Sensors = Sensors()
    estimator: Estimator = Estimator()
    channel: Channel = Channel()
    events: Annotated[tuple[Event, ...], Field(strict=False)] = ()  # a list is allowed, too

    @model_validator(mode="after")
    def _sections_agree(self) -> Scenario:
        if self.control.v2v_wait_ms is None:
            default = {"v2v_wait_ms": own_wait_ms(self)}
            # Only this default depends on another section. The scenario is still being built, so
            # it may be changed.
            object.__setattr__(self, "control", self.control.model_copy(update=default))
        refuse_disagreements(self)
        return self

    @property
    def brakes(self) -> tuple[Brake, ...]:
        """The events that are brakes."""
        return tuple(event for event in self.events if isinstance(event, Brake))

    @property
    def profiles(self) -> tuple[Sine | Trace, ...]:
        """The events that give a vehicle a speed to follow."""
        return tuple(event for event in self.events if not isinstance(event, Brake))

    @property
    def period_ns(self) -> int:
        """The length of a control cycle, ns."""
        return round(self.period_ms * NS_PER_MS)

    @property
    def v2v_wait_ns(self) -> int:
        """How long after t_k a vehicle waits for frames, ns."""
        return round((self.control.v2v_wait_ms or 0.0) * NS_PER_MS)

    @property
    def system_delay_ns(self) -> int:
        """The time from a decision to its effect, ns."""
        return round(self.control.system_delay_ms * NS_PER_MS)

    @property
    def beacon_age_limit_ns(self) -> int:
        """The age beyond which data of a neighbour are no longer used, ns."""
        return round(self.control.beacon_age_limit_ms * NS_PER_MS)

    @property
    def cycles_per_beacon(self) -> int:
        """Number of cycles from a beacon of a vehicle to its next one; at least that in CAMs."""
        if self.beacons.period_ms is None:
            return self.beacons.every
        return round(self.beacons.period_ms * NS_PER_MS) // self.period_ns

    @property
    def beacons_in_turn(self) -> bool:
        """Whether vehicles send in turn, instead of all in the same cycle."""
        return self.beacons.rule == "every-nth" or self.beacons.staggered

    @property
    def cycles(self) -> int:
        """The number of control cycles; cycle k starts at k · period."""
        return max(1, round(self.duration_s * NS_PER_S) // self.period_ns)

    @property
    def ring_length_m(self) -> float | None:
        """The length of the ring, m; None on an open road."""
        return self.fleet.size * self.fleet.gap_m if self.road.type == "ring" else None
