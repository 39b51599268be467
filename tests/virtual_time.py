"""Real-time agents run in this process on a virtual clock, which stops while an agent acts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from zenvoy.bus.agent import Envelope, decoded_jointly, decoders_of, joint_decoders_of
from zenvoy.bus.bundles import Parcel, pack, parcels_in
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.realtime_agent import Post, RealtimeAgent
from zenvoy.bus.topics import Topic
from zenvoy.channel.realtime import RealtimeChannel
from zenvoy.fleet.agents import agents_of
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.realtime import RealtimeVehicle
from zenvoy.world.realtime import RealtimeWorld

Logged = list[tuple[str, int, bytes]]
Delay = Callable[[Envelope, int], int | None]
"""The delay, ns, of a message that is sent at a time, ns, or None if it is lost."""


class VirtualBus:
    """Drives agents as RealtimeBus does, but on a clock that stops while an agent acts."""

    def __init__(self, agents: Sequence[RealtimeAgent], delay: Delay = lambda *_: 0) -> None:
        self._agents = agents  # at equal times, the first agent acts first
        self._delay = delay
        self._on_the_way: list[tuple[int, int, RealtimeAgent, Envelope]] = []
        self._sent = 0
        self.refused = 0
        self.together = 0  # messages of several vehicles that were read as one
        self.logged: Logged = []

    def run(self) -> None:
        """Run until the world, the agent of role `world`, is done."""
        world = next(agent for agent in self._agents if agent.role == "world")
        now_ns = 0
        while not world.done:
            comes_ns = min((entry[:2] for entry in self._on_the_way), default=None)
            due = [(max(now_ns, agent.due_ns), number) for number, agent in self._waiting()]
            acts = min(due, default=None)
            if comes_ns is not None and (acts is None or comes_ns[0] <= acts[0]):
                now_ns = max(now_ns, comes_ns[0])
                self._hand_over(comes_ns, now_ns)
                continue
            assert acts is not None, "nobody has anything to do"
            now_ns, number = acts
            self._send(self._agents[number].act(now_ns), now_ns)

    def _waiting(self) -> list[tuple[int, Any]]:
        return [
            (number, agent) for number, agent in enumerate(self._agents) if agent.due_ns is not None
        ]

    def _send(self, envelopes: Sequence[Envelope], now_ns: int) -> None:
        """Send messages; those for an agent that takes or reads them together go together."""
        bundles: dict[tuple[Topic[Any], int], list[Parcel]] = {}
        for envelope in envelopes:
            topic, vehicle, payload, time_ns, bundled = envelope
            if topic.logged_as is not None:
                self.logged.append((topic.logged_as, time_ns, payload))
            for number, agent in enumerate(self._agents):
                if agent.role != topic.reader or vehicle not in (agent.vehicles or (vehicle,)):
                    continue
                if topic in {*decoders_of(agent), *joint_decoders_of(agent)} and not bundled:
                    bundles.setdefault((topic, number), []).append((vehicle, payload))
                else:
                    self._put(envelope, agent, now_ns)
        for (topic, number), parcels in bundles.items():
            agent = self._agents[number]
            whole = Envelope(topic, parcels[0][0], pack(parcels), bundled=True)
            self._put(whole, agent, now_ns)

    def _put(self, envelope: Envelope, agent: RealtimeAgent, now_ns: int) -> None:
        delay_ns = self._delay(envelope, now_ns)
        if delay_ns is not None:
            self._sent += 1
            self._on_the_way.append((now_ns + delay_ns, self._sent, agent, envelope))

    def _hand_over(self, which: tuple[int, int], now_ns: int) -> None:
        entry = next(entry for entry in self._on_the_way if entry[:2] == which)
        self._on_the_way.remove(entry)
        *_, agent, (topic, vehicle, payload, _, bundled) = entry
        decoder, jointly = decoders_of(agent).get(topic), joint_decoders_of(agent).get(topic)
        parcels = parcels_in(topic, payload) if bundled and jointly is not None else []
        together = decoded_jointly(jointly, parcels)
        self.together += together is not None
        if together is not None:
            posts = [Post(topic, 0, together, payload, now_ns)]
        elif decoder is not None:
            posts = [Post(topic, 0, decoder(payload), payload, now_ns)]
        else:
            parcels = parcels_in(topic, payload) if bundled else [(vehicle, payload)]
            posts = [Post(topic, one, topic.decode(each), each, now_ns) for one, each in parcels]
        for post in posts:
            checked = together is not None
            fault = None if checked else agent.fault_in(topic, post.vehicle, post.message)
            self.refused += (fault or agent.take_in(post)) is not None


def realtime_agents(scenario: Scenario) -> list[RealtimeAgent]:
    """Return the agents of a run, in the order in which they act at equal times."""
    vehicles = range(1, scenario.fleet.size + 1)
    return [
        RealtimeChannel(scenario),
        RealtimeWorld(scenario),
        *(RealtimeVehicle(scenario, vehicle) for vehicle in vehicles),
    ]


def in_virtual_time(scenario: Scenario, delay: Delay = lambda *_: 0) -> Logged:
    """Return what a run in real time logs if messages take as long as `delay` says."""
    bus = VirtualBus(realtime_agents(scenario), delay)
    bus.run()
    return bus.logged


def in_lock_step(scenario: Scenario) -> Logged:
    """Return what a run in lock-step logs."""
    logged: Logged = []

    def log(topic: Topic[Any], time_ns: int, payload: bytes) -> None:
        assert topic.logged_as is not None
        logged.append((topic.logged_as, time_ns, payload))

    InProcessBus(agents_of(scenario), log).run()
    return logged
