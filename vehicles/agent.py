"""A vehicle under either clock: it takes in senses and frames, sends beacons, and decides."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.checks import fault_in_receive, fault_in_sense
from zenvoy.bus.refusals import ABSURD
from zenvoy.bus.topics import BEACON, COMMAND, vehicle_name
from zenvoy.keyed_random.draws import Purpose, uniforms
from zenvoy.laws import Setpoint
from zenvoy.laws.errors import LawError
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.beaconing import beaconing
from zenvoy.vehicles.control import FOLLOWING, controllers, reports_commands, shares_links
from zenvoy.vehicles.decision import Aim, Controller, Position, View, decide
from zenvoy.vehicles.knowledge import Knowledge
from zenvoy.vehicles.memory import Memory
from zenvoy.vehicles.messages import Instants, beacon, command, reported, shared, silence
from zenvoy.vehicles.neighbours import neighbours


class Vehicle:
    """Vehicle `vehicle` of 1..size, which knows others only by its radar and its radio.

    In each cycle it takes in its sense, then decides. `lock_step` and `realtime` decide when.
    """

    def __init__(self, scenario: Scenario, vehicle: int) -> None:
        settings = roster(scenario)[vehicle - 1]
        self.vehicle = vehicle
        self.name = vehicle_name(vehicle, scenario.fleet.size)
        self._phases = controllers(scenario, settings)
        every = [controller for _, controller in self._phases]
        self._position = _position(scenario, vehicle)
        self._period_ns, self._delay_ns = scenario.period_ns, scenario.system_delay_ns
        self._targets = settings.targets
        self._limits = settings.limits
        self._constant: Aim | None = None  # set if the schedule changes nothing
        if not self._targets.change:
            self._constant = self._aim_at(0)
        self._beacons = settings.beacons
        self._reports_commands = reports_commands(scenario)
        self._beaconing = beaconing(scenario, vehicle)
        self._estimates = any(one.law.needs.prediction for one in every)
        self._counts_neighbours = any(one.law.needs.sides for one in every)
        self._neighbours = neighbours(scenario, vehicle, every)
        self._known = Knowledge(
            scenario,
            self._neighbours,
            self._estimates,
            settings.lag_s,
            shares=shares_links(scenario),
            acts_on_shared=any(one.law.needs.shares_links for one in every),
        )
        self._memory, self._seed = Memory(), scenario.seed
        self._cycle = 0  # of the newest sense

    def fault_in_sense(self, sense: pb.Sense) -> str | None:
        """Return what is wrong with a sense, or None; it must be for this vehicle and on time."""
        return fault_in_sense(sense, self.vehicle, sense.cycle * self._period_ns)

    def fault_in_receive(
        self, receive: pb.Receive, time_ns: int | None, sent_by_ns: int
    ) -> str | None:
        """Return what is wrong with frames, or None; only frames that count are checked.

        time_ns: when they are due, or None if that is not known. sent_by_ns: the latest time at
        which a beacon in them can have been sent.
        """
        fault = fault_in_receive(receive, self.vehicle, time_ns)
        if fault is None and not self._known.radio.understands(receive, sent_by_ns):
            return ABSURD
        return fault

    def sense(self, sense: pb.Sense) -> Envelope:
        """Take in the sense of a new cycle, and return the beacon; raises LawError."""
        self._cycle = sense.cycle
        try:
            return Envelope(BEACON, self.vehicle, self._beacon(sense))
        except LawError as error:
            error.process = self.name
            raise

    def decide(self, now_ns: int, received: Sequence[pb.Receive]) -> Envelope:
        """Take in the frames that arrived since the last decision, and return the command.

        Raises LawError with the vehicle's name.
        """
        try:
            self._known.take_in(received)
            return Envelope(COMMAND, self.vehicle, self._decide(now_ns))
        except LawError as error:
            error.process = self.name
            raise

    def _beacon(self, sense: pb.Sense) -> bytes:
        """Return the beacon, with readings and the accelerations that the vehicle expects."""
        plan = self._known.sense(sense)
        sequence = self._beaconing.next(sense) if self._beacons else None
        if sequence is None:
            return silence(sense.cycle, sense.time_ns, sense.vehicle)
        sent = beacon(sense, self._known.radar, sequence, plan)
        if self._reports_commands:
            sent += reported(self._known.newest_command)
        report = self._known.report
        return sent if report is None else sent + shared(report)

    def _decide(self, now_ns: int) -> bytes:
        """Decide, and return the command together with the data that it is based on."""
        known, effective_ns = self._known, now_ns + self._delay_ns
        predicted = known.predict(effective_ns) if self._estimates else None
        controller = self._controller_at(now_ns)
        decision = decide(
            controller,
            self._position,
            self._view(controller, now_ns),
            predicted,
            self._aim_at(now_ns),
            self._memory.recalled(controller, self._cycle),
            self._period_ns * 1e-9,
            partial(self._uniform, self._cycle),
        )
        self._memory.keep(controller, self._cycle, decision.state)
        known.command(effective_ns, decision.acceleration)
        at = Instants(self._cycle, now_ns, effective_ns)
        return command(self.vehicle, at, decision, known, predicted, self._counts_neighbours)

    def _controller_at(self, now_ns: int) -> Controller:
        """Return the controller in force; a platoon leader has none to follow, so it runs FM."""
        while len(self._phases) > 1 and self._phases[1][0] <= now_ns:
            del self._phases[0]
        controller = self._phases[0][1]
        leads = controller.law.needs.leader and self._neighbours.leader == self.vehicle
        return FOLLOWING if leads else controller

    def _aim_at(self, now_ns: int) -> Aim:
        """Return what the schedule asks for now."""
        if self._constant is not None:
            return self._constant
        targets = self._targets
        cruises = targets.cruises_ns is not None and targets.cruises_ns <= now_ns
        setpoint = Setpoint(
            k_d=targets.k_d.at(now_ns),
            k_v=targets.k_v.at(now_ns),
            k_c=targets.k_c.at(now_ns),
            p_des=targets.desired_gap_m.at(now_ns),
            v_des=targets.desired_speed_mps.at(now_ns),
        )
        cruise = targets.desired_speed_mps.rate(now_ns) if cruises else None
        return Aim(setpoint, self._limits, cruise)

    def _view(self, controller: Controller, now_ns: int) -> View:
        """Return the data to decide on, as far as the law uses them."""
        known, view, needs = self._known, self._known.read(now_ns), controller.law.needs
        commands = controller.law.hears_commands(controller.parameters)
        if needs.sides:
            m = controller.law.sides(controller.parameters)
            view = view._replace(sides=known.sides(now_ns)[:m])
        if needs.predecessor and self._neighbours.ahead:
            other, seam_m = self._neighbours.ahead[0], self._neighbours.seam_ahead[0]
            motion = known.motion_of(other, seam_m, 1, commands=commands)
            view = view._replace(predecessor=motion)
        if needs.leader:  # the leader has a lower number, so no seam lies in between
            leader = self._neighbours.leader
            steps = self.vehicle - leader
            motion = known.motion_of(leader, 0.0, steps, commands=commands)
            view = view._replace(leader=motion)
        return view

    def _uniform(self, cycle: int, number: int) -> float:
        """Return random number `number` in [0, 1) for the law of this vehicle in a cycle."""
        return float(uniforms(self._seed, Purpose.LAW, self.vehicle, number, cycle)[0])


def _position(scenario: Scenario, vehicle: int) -> Position:
    if scenario.road.type == "ring":
        return Position.MIDDLE
    return {1: Position.FIRST, scenario.fleet.size: Position.LAST}.get(vehicle, Position.MIDDLE)
