"""A vehicle: senses, tells, hears, decides. One object, two steps per cycle."""

from __future__ import annotations

from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.topics import BEACON, COMMAND, RECEIVE, SENSE
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.controllers import Law
from zenvoy.vehicles.decision import Place, decide
from zenvoy.vehicles.knowledge import Knowledge
from zenvoy.vehicles.relative import Relative
from zenvoy.vehicles.state import LinkState

_NAN: Final = float("nan")
_NOTHING: Final = (_NAN, _NAN)
_NO_SPEED: Final = (_NAN, _NAN, _NAN)
_REST: Final = ("planned_from_ns", "planned_acceleration", "silent")
_BEACON: Final = FlatEncoder(pb.Beacon.DESCRIPTOR, leave_out=_REST)
_BEACON_OF_FIRST: Final = FlatEncoder(pb.Beacon.DESCRIPTOR, leave_out=("ahead", *_REST))
_COMMAND: Final = FlatEncoder(pb.Command.DESCRIPTOR, leave_out=("neighbours",))


class VehicleAgent:
    """Vehicle `vehicle` of 1..size; it knows of the others what its radar and its radio say."""

    role = "vehicle"

    def __init__(self, scenario: Scenario, vehicle: int) -> None:
        control, size = scenario.control, scenario.fleet.size
        self.vehicle = vehicle
        self.name = vehicle_name(vehicle, size)
        self._phases = control.phases
        self._place = _place(scenario, vehicle)
        self._period_ns, self._cycles = scenario.period_ns, scenario.cycles
        self._wait_ns, self._delay_ns = scenario.v2v_wait_ns, scenario.system_delay_ns
        self._age_limit_ns = scenario.beacon_age_limit_ns
        self._law = Law(
            k_d=control.gains.k_d,
            k_v=control.gains.k_v,
            k_c=control.gains.k_c,
            p_des=control.desired_gap_m,
            v_des=control.desired_speed_mps,
            a_max=control.acceleration_limit_mps2,
        )
        ahead_id = 0 if self._place is Place.FIRST else (vehicle - 2) % size + 1
        behind_id = 0 if self._place is Place.LAST else vehicle % size + 1
        self._estimates = "PBCM" in {model for _, model in self._phases}
        self._known = Knowledge(scenario, ahead_id, behind_id, self._estimates)
        self._cycle = 0
        self._senses = True

    @property
    def barrier(self) -> Barrier | None:
        """Sense of the cycle, then receive of the cycle; None after the last cycle."""
        if self._cycle == self._cycles:
            return None
        start_ns = self._cycle * self._period_ns
        if self._senses:
            return Barrier(start_ns, self._cycle, ((SENSE, (self.vehicle,)),))
        return Barrier(start_ns + self._wait_ns, self._cycle, ((RECEIVE, (self.vehicle,)),))

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Beacon on a sense, command on a receive."""
        if self._senses:
            self._senses = False
            return [Envelope(BEACON, self.vehicle, self._tell(inbox.one(SENSE)))]
        self._known.hear(inbox.one(RECEIVE))
        command = self._decide(now_ns)
        self._senses = True
        self._cycle += 1
        return [Envelope(COMMAND, self.vehicle, command)]

    def _tell(self, sense: pb.Sense) -> bytes:
        """Beacon: the readings, and what the vehicle expects of itself."""
        planned_from_ns, planned = self._known.sense(sense)
        cycle, time_ns = self._cycle, sense.time_ns
        motion = (sense.position, sense.speed, sense.acceleration)
        if sense.HasField("ahead"):
            link = sense.ahead
            head = _BEACON.encode(
                cycle, time_ns, self.vehicle, cycle, *motion, link.gap, link.speed
            )
        else:
            head = _BEACON_OF_FIRST.encode(cycle, time_ns, self.vehicle, cycle, *motion)
        plan = pb.Beacon(planned_from_ns=planned_from_ns, planned_acceleration=planned)
        return head + plan.SerializeToString()

    def _decide(self, now_ns: int) -> bytes:
        """Command for the instant at which it takes effect, and what it was based on."""
        known, effective_ns = self._known, now_ns + self._delay_ns
        age_ns = known.age_ns
        read = known.read()
        if age_ns > self._age_limit_ns:
            read = read._replace(behind=None)
        predicted = known.predict(effective_ns) if self._estimates else None
        while len(self._phases) > 1 and self._phases[1][0] <= now_ns:
            del self._phases[0]
        model = self._phases[0][1]
        a, mode = decide(
            model, self._place, read, predicted if model == "PBCM" else None, self._law
        )
        known.command(effective_ns, a)
        return _COMMAND.encode(
            self._cycle,
            now_ns,
            self.vehicle,
            effective_ns,
            a,
            mode,
            *_told(known.link_ahead, predicted.ahead if predicted else None),
            *_told(known.link_behind, predicted.behind if predicted else None),
            *((known.speed.estimate, known.speed.std, predicted.speed) if predicted else _NO_SPEED),
            age_ns,
        )


def vehicle_name(vehicle: int, size: int) -> str:
    """Name of a vehicle's process, so that names sort: `vehicle-07` of 40."""
    return f"vehicle-{vehicle:0{max(2, len(str(size)))}d}"


def _place(scenario: Scenario, vehicle: int) -> Place:
    if scenario.road.type == "ring":
        return Place.MIDDLE
    return {1: Place.FIRST, scenario.fleet.size: Place.LAST}.get(vehicle, Place.MIDDLE)


def _told(link: LinkState, predicted: Relative | None) -> tuple[float, ...]:
    """Fields of a LinkEstimate, in order."""
    estimate = link.estimate
    if estimate is None:
        return (*_NOTHING, *_NOTHING, *_NOTHING, link.measured_ns)
    return (*estimate, *link.std, *(predicted or _NOTHING), link.measured_ns)
