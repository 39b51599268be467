"""Several vehicles in one process: to the bus they are one participant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.hosts import Host
from zenvoy.bus.live import Post
from zenvoy.bus.topics import RECEIVE, Topic
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.agent import VehicleAgent
from zenvoy.vehicles.live import LiveVehicle


class HostedVehicles:
    """Vehicles in lock-step: all of them take the same step, in order of number."""

    role = "vehicle"

    def __init__(self, scenario: Scenario, host: Host) -> None:
        self.name, self.vehicles = host
        self._agents: Final = {one: VehicleAgent(scenario, one) for one in host.vehicles}

    @property
    def barrier(self) -> Barrier | None:
        """What all of them wait for, one as the other."""
        barrier = self._first.barrier
        if barrier is None:
            return None
        ((topic, _),) = barrier.needs
        return barrier._replace(needs=((topic, self.vehicles),))

    def flaw(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """As that vehicle finds."""
        return self._agents[vehicle].flaw(topic, vehicle, message)

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
    def _first(self) -> VehicleAgent:
        return self._agents[self.vehicles[0]]


class LiveHostedVehicles:
    """Vehicles on the wall clock: the one whose time has come first acts first."""

    role = "vehicle"
    done = False
    together = True
    quiet = frozenset({RECEIVE})

    def __init__(self, scenario: Scenario, host: Host) -> None:
        self.name, self.vehicles = host
        self._agents: Final = {one: LiveVehicle(scenario, one) for one in host.vehicles}

    @property
    def due_ns(self) -> int | None:
        """When the first of them acts."""
        first = self._first()
        return None if first is None else first[0]

    def flaw(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """As that vehicle finds."""
        return self._agents[vehicle].flaw(topic, vehicle, message)

    def hear(self, post: Post) -> bool:
        """Hand a message to the vehicle that it is for."""
        return self._agents[post.vehicle].hear(post)

    def act(self, now_ns: int) -> list[Envelope]:
        """Let the first of them act."""
        first = self._first()
        assert first is not None
        return self._agents[first[1]].act(now_ns)

    def _first(self) -> tuple[int, int] | None:
        """Who acts next, as far as is known: when, and number of the vehicle."""
        return min(self._due(), default=None)

    def _due(self) -> Sequence[tuple[int, int]]:
        return [
            (due_ns, vehicle)
            for vehicle, agent in self._agents.items()
            if (due_ns := agent.due_ns) is not None
        ]
