"""A whole scenario, and its small sections: frozen, typed, with units in the names.

Every field has a default, so that a scenario file contains only differences from the paper's
setting (40 vehicles on a ring of 1500 m, Table IV). docs/decisions.md explains the defaults that
the paper does not give.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import ConfigDict, Field, model_validator

from zenvoy.laws.estimator import KALMAN
from zenvoy.scenarios.schema.agreement import refuse_disagreements
from zenvoy.scenarios.schema.channel import Channel
from zenvoy.scenarios.schema.control import Control
from zenvoy.scenarios.schema.events import Brake, Event, Sine, Trace
from zenvoy.scenarios.schema.faults import AnyFault
from zenvoy.scenarios.schema.fleet import Fleet, Vehicle
from zenvoy.scenarios.schema.inputs import EstimatorKind, Parameters
from zenvoy.scenarios.schema.waits import own_wait_ms
from zenvoy.values.section import NS_PER_MS, NS_PER_S, NonNegative, Percent, Positive, Section, Seed


class Road(Section):
    """The shape of the road. The length of a ring is fleet.size · fleet.gap_m."""

    type: Literal["ring", "open"] = "ring"
    """A ring of fleet.size · fleet.gap_m, or a road with a first and a last vehicle."""


class Sensors(Section):
    """Sensor errors: readings of gaps and absolute speeds are multiplied by 1 + e, |e| ≤ error."""

    error: Annotated[float, Field(ge=0, lt=1), Percent] = 0.1
    """Largest relative error of readings of gaps and absolute speeds."""
    distribution: Literal["uniform", "gaussian"] = "uniform"
    """Distribution of the error; both have the same variance."""
    position_std_m: NonNegative = 0.0
    """Standard deviation of the own position."""

    @property
    def error_std(self) -> float:
        """The standard deviation of the error as a fraction, the same for both distributions."""
        return self.error / 3**0.5


class Estimator(Section):
    """The filters of links and own speed; acceleration_std_mps2 sets their process noise.

    On these linear models ekf and ukf agree with kalman to rounding; docs/estimators.md compares.
    """

    kind: EstimatorKind = KALMAN
    """The filter of PBCM; see [Estimators](estimators.md)."""
    parameters: Parameters = ()
    """Parameters of an estimator of your own; see [Extending Zenvoy](extending.md)."""
    acceleration_std_mps2: Positive = 0.5
    """Process noise of the link filters."""


class Beacons(Section):
    """When vehicles send beacons: in every cycle, in every n-th cycle (in turn), or like CAMs.

    period_ms is a beacon period of its own, a multiple of the control period; null: every cycle.
    All vehicles send at the same time, or in turn if they are staggered. etsi-cam follows ETSI EN
    302 637-2: after 4 m or 0.5 m/s, 100 to 1000 ms apart.
    """

    rule: Literal["every-cycle", "every-nth", "etsi-cam"] = "every-cycle"
    """`etsi-cam`: after 4 m or 0.5 m/s, 100 to 1000 ms apart."""
    every: Annotated[int, Field(ge=1, le=1000)] = 1
    """For every-nth: n, in cycles; vehicles take turns."""
    period_ms: Annotated[float, Field(ge=1, le=1_000_000)] | None = None
    """For every-cycle: time between two beacons of a vehicle, a multiple of `period_ms` of the
    scenario; null: a cycle."""
    staggered: bool = False
    """`period_ms`: vehicles take turns, a cycle apart; false: all send at the same time."""


class LogOptions(Section):
    """What the log of a run contains beside its data."""

    scene: bool = False
    """Whether the log has the vehicles as a scene for 3D panels, see
    [Foxglove and Lichtblick](foxglove.md)."""


_EXTENDS: Final = {
    "type": "string",
    "description": "The scenario from which this one differs.",
}


def _extends_in_front(schema: dict[str, Any]) -> None:
    """Allow `extends`: `zenvoy.scenarios.reading.extends` merges in the file that it names."""
    schema["properties"] = {"extends": _EXTENDS, **schema["properties"]}


class Scenario(Section):
    """A whole experiment."""

    model_config = ConfigDict(json_schema_extra=_extends_in_front)

    description: str = ""
    """A line for `zenvoy scenarios`."""
    duration_s: Positive = 500.0
    """Simulated time; at least one period."""
    period_ms: Annotated[float, Field(ge=1, le=10_000)] = 100.0
    """The control cycle."""
    clock: Literal["lock-step", "realtime"] = "lock-step"
    """As fast as possible, or in real time ([Real time](real-time.md))."""
    speed: Annotated[float, Field(ge=0.1, le=10)] = 1.0
    """In real time: simulated time per wall time."""
    max_clock_error_ms: Annotated[float, Field(gt=0, le=1000)] = 5.0
    """In real time over several machines: how badly a machine may know the world's clock."""
    seed: Seed = 1
    """Seed of all random draws."""
    stall_limit_s: Positive = 10.0
    """Wall time after which a stalled process is named and the run ends."""
    on_collision: Literal["continue", "stop"] = "continue"
    """Whether the run goes on after a collision."""
    on_vehicle_loss: Literal["abort", "coast", "brake", "restart"] = "abort"
    """What follows when a fault kills a vehicle's process, see `process-killed`."""
    public_truth: bool = False
    """Whether programs that look on may read the state of all vehicles while the run goes on, see
    [Security](security.md)."""
    road: Road = Road()
    """The shape of the road."""
    fleet: Fleet = Fleet()
    """The vehicles, and where they are at the start."""
    vehicle: Vehicle = Vehicle()
    """The actuators of all vehicles."""
    control: Control = Control()
    """The control law, its aims and its timing."""
    beacons: Beacons = Beacons()
    """When vehicles send beacons."""
    sensors: Sensors = Sensors()
    """Errors of the sensors."""
    estimator: Estimator = Estimator()
    """The filter of the estimates."""
    channel: Channel = Channel()
    """The radio channel."""
    log: LogOptions = LogOptions()
    """What the log contains beside its data."""
    events: Annotated[tuple[Event, ...], Field(strict=False)] = ()  # a list is allowed, too
    """Events of single vehicles, see below."""
    faults: Annotated[tuple[AnyFault, ...], Field(strict=False)] = ()  # a list is allowed, too
    """Faults of sensors, transmitters, actuators and processes, see below."""

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
    def max_clock_error_ns(self) -> int:
        """How badly a machine may know the world's clock in real time, ns of wall time."""
        return round(self.max_clock_error_ms * 1e6)

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
