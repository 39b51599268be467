"""The vehicles of a shared process, which are one participant of the bus."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.topics import RECEIVE, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.scenarios import Scenario, attendance
from zenvoy.vehicles.lock_step import LockStepVehicle
from zenvoy.vehicles.realtime import RealtimeVehicle


class LockStepVehicles:
    """Vehicles in lock-step; those that take part in a cycle take the same step, in order."""

    role = "vehicle"

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        self._agents: Final = {one: LockStepVehicle(scenario, one) for one in process.vehicles}
        self._next: Sequence[int] = self.vehicles  # those of the next step
        self._together = not attendance(scenario).absences.keys() & set(self.vehicles)

    @property
    def barrier(self) -> Barrier | None:
        """The messages that all vehicles of the next step wait for, each for the same topic."""
        if self._together:
            barrier = self._agents[self.vehicles[0]].barrier
            return None if barrier is None else self._of_all(barrier)
        barriers = {one: agent.barrier for one, agent in self._agents.items()}
        waiting = {one: barrier for one, barrier in barriers.items() if barrier is not None}
        if not waiting:
            return None
        first = min(waiting.values(), key=lambda barrier: barrier.cycle)
        self._next = [one for one, its in waiting.items() if its.cycle == first.cycle]
        return self._of_all(first)

    def _of_all(self, barrier: Barrier) -> Barrier:
        """Return the barrier of one vehicle for all vehicles of the next step."""
        ((topic, _),) = barrier.needs
        return barrier._replace(needs=((topic, self._next),))

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why the vehicle refuses a message, or None."""
        return self._agents[vehicle].fault_in(topic, vehicle, message)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Return what the vehicles of the step send."""
        agents = [self._agents[one] for one in self._next]
        shares = inbox.each()
        return [
            envelope
            for agent, share in zip(agents, shares, strict=True)
            for envelope in agent.step(now_ns, share)
        ]


class RealtimeVehicles:
    """Vehicles in real time: the one that is due first acts first."""

    role = "vehicle"
    done = False
    sends_together = True
    may_wait = frozenset({RECEIVE})

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        self._agents: Final = {one: RealtimeVehicle(scenario, one) for one in process.vehicles}
        self._due_ns: dict[int, int] = {}  # by vehicle, if it knows when it acts next

    @property
    def due_ns(self) -> int | None:
        """When the first vehicle acts."""
        return min(self._due_ns.values(), default=None)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why the vehicle refuses a message, or None."""
        return self._agents[vehicle].fault_in(topic, vehicle, message)

    def take_in(self, post: Post) -> str | None:
        """Hand a message to its vehicle."""
        agent = self._agents[post.vehicle]
        reason = agent.take_in(post)
        self._note(agent)
        return reason

    def act(self, now_ns: int) -> list[Envelope]:
        """Let the vehicle that is due first act."""
        agent = self._agents[min(self._due_ns, key=lambda one: (self._due_ns[one], one))]
        sent = agent.act(now_ns)
        self._note(agent)
        return sent

    def _note(self, agent: RealtimeVehicle) -> None:
        """Note when a vehicle acts next; this changes only when it takes in a message or acts."""
        due_ns = agent.due_ns
        if due_ns is None:
            self._due_ns.pop(agent.vehicle, None)
        else:
            self._due_ns[agent.vehicle] = due_ns
