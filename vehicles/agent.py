"""A vehicle: senses, tells, hears, decides. One object, two steps per cycle."""

from __future__ import annotations

from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.topics import BEACON, COMMAND, RECEIVE, SENSE
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.controllers import Law
from zenvoy.vehicles.decision import Decision, Place, View, decide
from zenvoy.vehicles.knowledge import Knowledge
from zenvoy.vehicles.relative import Relative
from zenvoy.vehicles.state import LinkState

_NAN: Final = float("nan")
_UNKNOWN: Final = Relative(_NAN, _NAN)


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
            beacon = self._tell(inbox.one(SENSE))
            return [Envelope(BEACON, self.vehicle, beacon.SerializeToString())]
        self._known.hear(inbox.one(RECEIVE))
        command = self._decide(now_ns)
        self._senses = True
        self._cycle += 1
        return [Envelope(COMMAND, self.vehicle, command.SerializeToString())]

    def _tell(self, sense: pb.Sense) -> pb.Beacon:
        planned_from_ns, planned = self._known.sense(sense)
        return pb.Beacon(
            cycle=self._cycle,
            time_ns=sense.time_ns,
            vehicle=self.vehicle,
            sequence=self._cycle,
            position=sense.position,
            speed=sense.speed,
            acceleration=sense.acceleration,
            ahead=sense.ahead if sense.HasField("ahead") else None,
            planned_from_ns=planned_from_ns,
            planned_acceleration=planned,
        )

    def _decide(self, now_ns: int) -> pb.Command:
        effective_ns = now_ns + self._delay_ns
        age_ns = self._known.age_ns
        read = self._known.read()
        if age_ns > self._age_limit_ns:
            read = read._replace(behind=None)
        predicted = self._known.predict(effective_ns) if self._estimates else None
        while len(self._phases) > 1 and self._phases[1][0] <= now_ns:
            del self._phases[0]
        model = self._phases[0][1]
        decision = decide(
            model, self._place, read, predicted if model == "PBCM" else None, self._law
        )
        self._known.command(effective_ns, decision.acceleration)
        return self._report(now_ns, effective_ns, age_ns, decision, predicted)

    def _report(
        self,
        now_ns: int,
        effective_ns: int,
        age_ns: int,
        decision: Decision,
        predicted: View | None,
    ) -> pb.Command:
        known = self._known
        return pb.Command(
            cycle=self._cycle,
            time_ns=now_ns,
            vehicle=self.vehicle,
            effective_ns=effective_ns,
            acceleration=decision.acceleration,
            mode=decision.mode,
            ahead=_told(known.link_ahead, predicted.ahead if predicted else None),
            behind=_told(known.link_behind, predicted.behind if predicted else None),
            speed=known.speed.estimate if predicted else _NAN,
            speed_std=known.speed.std if predicted else _NAN,
            predicted_speed=predicted.speed if predicted else _NAN,
            age_ns=age_ns,
        )


def vehicle_name(vehicle: int, size: int) -> str:
    """Name of a vehicle's process, so that names sort: `vehicle-07` of 40."""
    return f"vehicle-{vehicle:0{max(2, len(str(size)))}d}"


def _place(scenario: Scenario, vehicle: int) -> Place:
    if scenario.road.type == "ring":
        return Place.MIDDLE
    return {1: Place.FIRST, scenario.fleet.size: Place.LAST}.get(vehicle, Place.MIDDLE)


def _told(link: LinkState, predicted: Relative | None) -> pb.LinkEstimate:
    estimate = link.estimate
    gap_std, speed_std = link.std if estimate is not None else (_NAN, _NAN)
    now, then = estimate or _UNKNOWN, predicted or _UNKNOWN
    return pb.LinkEstimate(
        gap=now.p,
        speed=now.v,
        gap_std=gap_std,
        speed_std=speed_std,
        predicted_gap=then.p,
        predicted_speed=then.v,
        measured_ns=link.measured_ns,
    )
