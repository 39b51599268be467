"""Mutants between real messages do not change what an agent sends, on any clock."""

from __future__ import annotations

import tempfile
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from tests.attack.messages import Seen, streams
from tests.attack.mutator import Mutator
from tests.fleet_of_three import FLEET, SIZE, scenario_of
from tests.virtual_time import VirtualBus, in_lock_step, realtime_agents
from zenvoy.bus.agent import Agent, Envelope
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.realtime_agent import Post, admit
from zenvoy.bus.topics import Topic
from zenvoy.fleet.agents import agents_of
from zenvoy.scenarios import Scenario


@dataclass(frozen=True, slots=True)
class Recorded:
    """An agent's part in a run: the messages that it received, and those that it sent."""

    came: list[Seen] = field(default_factory=list)
    sent: list[Envelope] = field(default_factory=list)


class Party:
    """An agent and its mailbox, driven as its process drives it."""

    def __init__(self, agent: Agent) -> None:
        self.agent, self.mailbox = agent, Mailbox(agent.fault_in)
        self.recorded = Recorded()

    def reads(self, topic: Topic[Any], vehicle: int) -> bool:
        return topic.reader == self.agent.role and vehicle in (self.agent.vehicles or (vehicle,))

    def proceed(self) -> list[Envelope]:
        """Take every step whose messages are there, and return what the agent sends."""
        news: list[Envelope] = []
        while (barrier := self.agent.barrier) is not None and self.mailbox.met(barrier):
            news += self.agent.step(barrier.now_ns, self.mailbox.take(barrier))
        self.recorded.sent.extend(news)
        return news


@cache
def recorded_run() -> tuple[Scenario, dict[str, Recorded]]:
    """Record a run without mutants, by agent. It ends, so no real message is refused."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = scenario_of(Path(folder), f"duration_s: 3\n{FLEET}")
    fleet = [Party(agent) for agent in agents_of(scenario)]
    news = [envelope for party in fleet for envelope in party.proceed()]
    while news:
        topic, vehicle, payload, *_ = news.pop(0)
        for party in fleet:
            if party.reads(topic, vehicle):
                cycle = topic.decode(payload).cycle
                party.recorded.came.append(Seen(topic, vehicle, payload, cycle))
                assert party.mailbox.put(topic, vehicle, payload) is None
                news += party.proceed()
    assert [party.agent.barrier for party in fleet] == [None] * len(fleet)
    return scenario, {party.agent.name: party.recorded for party in fleet}


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32), most=st.integers(1, 5))
@pytest.mark.parametrize("name", ["world", "channel", "vehicle-02"])
def test_mutants_between_real_messages_change_nothing(name: str, seed: int, most: int) -> None:
    scenario, recorded = recorded_run()
    random = Random(seed)
    (agent,) = (agent for agent in agents_of(scenario) if agent.name == name)
    party, mutator = Party(agent), Mutator("r", SIZE, seed)
    keys: dict[str, Any] = dict(streams("r", SIZE))
    party.proceed()
    for seen in in_some_order(recorded[name].came, random):
        for mutant in mutator.mutants(random.randrange(most)):
            topic, vehicle = keys.get(mutant.key, (None, 0))
            if topic is not None and party.reads(topic, vehicle) and mutant.payload:
                assert party.mailbox.put(topic, vehicle, mutant.payload) is not None
        assert party.mailbox.put(seen.topic, seen.vehicle, seen.payload) is None
        party.proceed()
        mutator.see(seen)
    assert party.agent.barrier is None
    assert party.recorded.sent == recorded[name].sent


def in_some_order(came: list[Seen], random: Random) -> list[Seen]:
    """Interleave the streams at random. Each keeps its order and lags by less than a cycle."""
    return sorted(came, key=lambda seen: seen.cycle + random.random() * 0.99)


@settings(max_examples=25, deadline=None, phases=[Phase.generate])
@given(seed=st.integers(0, 2**32))
def test_in_real_time_mutants_change_nothing(
    tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    """Without lateness, the log in real time equals the log in lock-step, bit for bit."""
    folder = tmp_path_factory.mktemp("realtime")
    scenario = scenario_of(folder, f"duration_s: 2\n{FLEET}")
    bus = AttackedBus(realtime_agents(scenario), seed)
    bus.run()
    alone = VirtualBus(realtime_agents(scenario))
    alone.run()
    assert bus.logged == alone.logged
    assert {row for row in bus.logged if row[0] != "/realtime"} == set(in_lock_step(scenario))
    assert bus.reasons.total() > 500
    assert bus.reasons.keys() >= {"malformed", "foreign", "stale", "mistimed", "absurd"}


class AttackedBus(VirtualBus):
    """A bus that sends mutants after each real message, to the readers of their keys."""

    def __init__(self, agents: Any, seed: int) -> None:
        super().__init__(agents)
        self._mutator = Mutator("r", SIZE, seed)
        self._keys: dict[str, Any] = dict(streams("r", SIZE))
        self.reasons: Counter[str] = Counter()

    def _hand_over(self, which: tuple[int, int], now_ns: int) -> None:
        entry = next(entry for entry in self._on_the_way if entry[:2] == which)
        *_, (topic, vehicle, payload, *_) = entry
        super()._hand_over(which, now_ns)
        self._mutator.see(Seen(topic, vehicle, payload, topic.decode(payload).cycle))
        for mutant in self._mutator.mutants(3):
            of, whose = self._keys.get(mutant.key, (None, 0))
            for agent in self._agents:
                vehicles = agent.vehicles or (whose,)
                if of is not None and of.reader == agent.role and whose in vehicles:
                    self._send_mutant(agent, of, whose, mutant.payload or b"\xff", now_ns)

    def _send_mutant(
        self, agent: Any, topic: Topic[Any], vehicle: int, payload: bytes, now_ns: int
    ) -> None:
        try:
            message = topic.decode(payload)
        except PayloadError:
            self.reasons["malformed"] += 1
            return
        reason = agent.fault_in(topic, vehicle, message)
        reason = reason or admit(agent, Post(topic, vehicle, message, payload, now_ns))
        assert reason is not None
        self.reasons[reason] += 1
