"""The vehicles of a shared process: to the bus they are one participant."""

from __future__ import annotations

from typing import Any, Final

from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.realtime import Post
from zenvoy.bus.topics import RECEIVE, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.lock_step import LockStepVehicle
from zenvoy.vehicles.realtime import RealtimeVehicle


class LockStepVehicles:
    """Vehicles in lock-step: all of them take the same step, in order of number."""

    role = "vehicle"

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        self._agents: Final = {one: LockStepVehicle(scenario, one) for one in process.vehicles}

    @property
    def barrier(self) -> Barrier | None:
        """What all of them wait for, one as the other."""
        barrier = self._first.barrier
        if barrier is None:
            return None
        ((topic, _),) = barrier.needs
        return barrier._replace(needs=((topic, self.vehicles),))

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """As that vehicle finds."""
        return self._agents[vehicle].fault_in(topic, vehicle, message)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """The step of each."""
        agents = self._agents.values()
        shares = inbox.each()
        return [
            envelope
            for agent, share in zip(agents, shares, strict=True)
            for envelope in agent.step(now_ns, share)
        ]

    @property
    def _first(self) -> LockStepVehicle:
        return self._agents[self.vehicles[0]]


class RealtimeVehicles:
    """Vehicles in real time: the one whose time has come first acts first."""

    role = "vehicle"
    done = False
    sends_together = True
    may_wait = frozenset({RECEIVE})

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        self._agents: Final = {one: RealtimeVehicle(scenario, one) for one in process.vehicles}
        self._due_ns: dict[int, int] = {}  # by vehicle, of those that know when they act next

    @property
    def due_ns(self) -> int | None:
        """When the first of them acts."""
        return min(self._due_ns.values(), default=None)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """As that vehicle finds."""
        return self._agents[vehicle].fault_in(topic, vehicle, message)

    def take_in(self, post: Post) -> str | None:
        """Hand a message to the vehicle that it is for."""
        agent = self._agents[post.vehicle]
        reason = agent.take_in(post)
        self._note(agent)
        return reason

    def act(self, now_ns: int) -> list[Envelope]:
        """Let the first of them act."""
        agent = self._agents[min(self._due_ns, key=lambda one: (self._due_ns[one], one))]
        sent = agent.act(now_ns)
        self._note(agent)
        return sent

    def _note(self, agent: RealtimeVehicle) -> None:
        """When it acts next, which changes only where it hears or acts."""
        due_ns = agent.due_ns
        if due_ns is None:
            self._due_ns.pop(agent.vehicle, None)
        else:
            self._due_ns[agent.vehicle] = due_ns
