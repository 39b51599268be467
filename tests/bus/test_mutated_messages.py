"""Mutated messages are refused, and change nothing in what a fleet does.

What is claimed, and what is not, is in docs/robustness.md.
"""

from __future__ import annotations

import math
import re
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random
from typing import Any, Final

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from tests.attack import FIRST_CYCLE, MARK, Mutator, Seen, streams
from tests.conftest import LIMIT_S, Log, read_log, run
from tests.virtual_time import VirtualBus, in_lock_step, realtime_agents
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Agent, Envelope
from zenvoy.bus.mailbox import WINDOW, Mailbox
from zenvoy.bus.realtime import Post, admit
from zenvoy.bus.refusals import Refusals
from zenvoy.bus.topics import BEACON, COMMAND, LINKS, POSITIONS, RECEIVE, SENSE, Topic
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.channel.realtime import RealtimeChannel
from zenvoy.fleet.agents import agents_of
from zenvoy.scenarios import Scenario, load
from zenvoy.vehicles.lock_step import LockStepVehicle
from zenvoy.vehicles.realtime import RealtimeVehicle
from zenvoy.world.lock_step import LockStepWorld
from zenvoy.world.realtime import RealtimeWorld

SIZE: Final = 3
FLEET: Final = """
fleet: {size: 3}
control: {v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""
ALONE: Final = ("vehicle-01", "vehicle-02", "vehicle-03")
TOGETHER: Final = ("vehicles-01-02", "vehicle-03")
MOST_LINES: Final = 22  # 20 kinds and sources, that there are more, and the counts


def under_attack(
    folder: Path, scenario: str, vehicles: tuple[str, ...] = ALONE
) -> tuple[Log, dict[str, Counter[str]]]:
    """The log of a run that must complete, and what each process has refused, by reason."""
    folder.mkdir()
    (folder / "s.yaml").write_text(scenario)
    arguments = [str(folder / "s.yaml"), str(folder / "out"), "200"]
    arguments.append("1" if vehicles == ALONE else "2")
    ended = subprocess.run(
        [sys.executable, "-m", "tests.attack", *arguments],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        timeout=2 * LIMIT_S,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, ""), ended
    log = read_log(folder / "out" / "run.mcap")
    assert log.result["end"] == "complete"
    logs = {path.stem: path for path in (folder / "out" / "logs").iterdir()}
    assert logs.keys() == {"world", "channel", "attacker", *vehicles}
    assert logs.pop("attacker").read_text() == ""
    return log, {name: refused(name, path.read_text()) for name, path in logs.items()}


def refused(name: str, text: str) -> Counter[str]:
    """The counts that a process's log ends with; it says nothing else that is long."""
    lines = text.splitlines()
    assert len(lines) <= MOST_LINES
    assert len(set(lines)) == len(lines)
    assert all(line.startswith(f"{name}: ") for line in lines)
    reasons = {line.split(": ")[2].split(",")[0] for line in lines if ": refused: " in line}
    counts = Counter({why: int(n) for n, why in re.findall(r"(\d+) (\w+)", lines[-1])})
    assert lines[-1].startswith(f"{name}: messages refused: ")
    assert reasons <= counts.keys()
    return counts


@pytest.mark.parametrize("vehicles", [ALONE, TOGETHER], ids=["alone", "together"])
def test_a_run_in_lock_step_keeps_its_fingerprint(
    tmp_path: Path, vehicles: tuple[str, ...]
) -> None:
    # 1,000 cycles of 200 mutants each, however busy the machine is.
    scenario = f"duration_s: 100\n{FLEET}"
    attacked, counts = under_attack(tmp_path / "attacked", scenario, vehicles)
    alone = run(tmp_path / "alone", scenario, "--bus", "in-process")
    assert attacked.result["fingerprint"] == alone.result["fingerprint"]
    assert sum(map(Counter.total, counts.values())) >= 100_000
    for name, reasons in counts.items():
        assert reasons.total() >= 5_000, name
        assert reasons.keys() >= {
            "malformed",
            "foreign",
            "stale",
            "early",
            "duplicate",
            "mistimed",
        }, name


@pytest.mark.parametrize("vehicles", [ALONE, TOGETHER], ids=["alone", "together"])
def test_a_run_in_real_time_logs_nothing_of_it(tmp_path: Path, vehicles: tuple[str, ...]) -> None:
    scenario = f"duration_s: 5\nclock: realtime\n{FLEET}"
    log, counts = under_attack(tmp_path / "attacked", scenario, vehicles)
    assert log.result["cycles"] == "50"
    assert all(reasons.total() >= 500 for reasons in counts.values())
    for name, reasons in counts.items():
        assert reasons.keys() >= {"malformed", "foreign", "stale", "mistimed"}, name
    commands = [pb.FleetCommand.FromString(message.data) for message in log.of("/fleet/command")]
    decided = [a for row in commands for a in row.acceleration if not math.isnan(a)]
    assert len(decided) > len(commands)  # of three each; the rest had no time left
    assert MARK not in decided
    assert max(map(abs, decided)) <= 3.0
    alone = run(tmp_path / "alone", f"{scenario}\nspeed: 1", "--set", "clock=lock-step")
    assert fates(log) <= fates(alone)
    heard = [
        row
        for message in log.of("/realtime")
        for row_of_cycle in [pb.RealTime.FromString(message.data)]
        for row in zip(
            row_of_cycle.source, row_of_cycle.destination, row_of_cycle.arrived_ns, strict=True
        )
    ]
    assert len(set(heard)) == len(heard)


def fates(log: Log) -> set[tuple[int, ...]]:
    """Return the outcome of each frame, without lateness; each frame has one."""
    tables = [pb.Frames.FromString(message.data) for message in log.of("/v2v/frames")]
    rows = [
        row
        for table in tables
        for row in zip(
            table.source, table.destination, table.sequence, table.latency_ns, strict=True
        )
    ]
    assert len(set(rows)) == len(rows)
    return set(rows)


@dataclass(frozen=True, slots=True)
class Recorded:
    """An agent's part in a run: what came to it, and what it made of that."""

    came: list[Seen] = field(default_factory=list)
    sent: list[Envelope] = field(default_factory=list)


def scenario_of(folder: Path, text: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load(folder / "s.yaml").scenario


class Party:
    """An agent with its mailbox, driven as its process drives it."""

    def __init__(self, agent: Agent) -> None:
        self.agent, self.mailbox = agent, Mailbox(agent.fault_in)
        self.recorded = Recorded()

    def reads(self, topic: Topic[Any], vehicle: int) -> bool:
        return topic.reader == self.agent.role and vehicle in (self.agent.vehicles or (vehicle,))

    def proceed(self) -> list[Envelope]:
        """All steps for which everything is there."""
        news: list[Envelope] = []
        while (barrier := self.agent.barrier) is not None and self.mailbox.met(barrier):
            news += self.agent.step(barrier.now_ns, self.mailbox.take(barrier))
        self.recorded.sent.extend(news)
        return news


@cache
def recorded_run() -> tuple[Scenario, dict[str, Recorded]]:
    """A run without mutants, by name of agent. That it ends shows that no real one is refused."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = scenario_of(Path(folder), f"duration_s: 3\n{FLEET}")
    fleet = [Party(agent) for agent in agents_of(scenario)]
    news = [envelope for party in fleet for envelope in party.proceed()]
    while news:
        topic, vehicle, payload, _ = news.pop(0)
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
def test_any_rubbish_between_real_messages_gives_the_same(name: str, seed: int, most: int) -> None:
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
    """Streams keep their order; which of them is ahead changes, by less than a cycle."""
    return sorted(came, key=lambda seen: seen.cycle + random.random() * 0.99)


@settings(max_examples=25, deadline=None, phases=[Phase.generate])
@given(seed=st.integers(0, 2**32))
def test_in_real_time_rubbish_changes_nothing_either(
    tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    """As by RealtimeBus, but without lateness: then the log is that of lock-step, bit for bit."""
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
    """After each real message come mutants, to whoever reads their keys."""

    def __init__(self, agents: Any, seed: int) -> None:
        super().__init__(agents)
        self._mutator = Mutator("r", SIZE, seed)
        self._keys: dict[str, Any] = dict(streams("r", SIZE))
        self.reasons: Counter[str] = Counter()

    def _hand_over(self, which: tuple[int, int], now_ns: int) -> None:
        entry = next(entry for entry in self._on_the_way if entry[:2] == which)
        *_, (topic, vehicle, payload, _) = entry
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
        except Exception:  # noqa: BLE001  # what it is that cannot be decoded is no matter here
            self.reasons["malformed"] += 1
            return
        reason = agent.fault_in(topic, vehicle, message)
        reason = reason or admit(agent, Post(topic, vehicle, message, payload, now_ns))
        assert reason is not None
        self.reasons[reason] += 1


K: Final = 5
T_NS: Final = 100_000_000
AT: Final[dict[str, Any]] = {"cycle": K, "time_ns": K * T_NS}
DECIDED: Final[dict[str, Any]] = {"cycle": K, "time_ns": K * T_NS + 50_000_000}
NAN: Final = float("nan")


def frames(**changes: Any) -> bytes:
    row = {
        "source": [1],
        "destination": [2],
        "sequence": [K],
        "sent_ns": [K * T_NS],
        "arrived_ns": [K * T_NS],
        "latency_ns": [0],
        "distance": [37.5],
        "outcome": [1],
    }
    return pb.Frames(**{**AT, **row, **changes}).SerializeToString()


def beacon_of(source: int = 2, **changes: Any) -> pb.Beacon:
    plan = {"planned_from_ns": [K * T_NS], "planned_acceleration": [0.1]}
    values: dict[str, Any] = {**AT, "vehicle": source, "sequence": K, **plan, **changes}
    return pb.Beacon(**values)


def receive(*beacons: bytes, **changes: Any) -> pb.Receive:
    rows = {"source": [2] * len(beacons), "arrived_ns": [0] * len(beacons), "beacon": beacons}
    return pb.Receive(**{**DECIDED, "vehicle": 1, **rows, **changes})


EFFECTIVE: Final = DECIDED["time_ns"] + 70_000_000
COMMANDED: Final[dict[str, Any]] = {
    **DECIDED,
    "vehicle": 1,
    "effective_ns": EFFECTIVE,
    "acceleration": 0.5,
}
GOOD: Final[dict[Topic[Any], tuple[int, Any]]] = {
    SENSE: (1, pb.Sense(**AT, vehicle=1, ahead=pb.Link(gap=37.5), speed=30)),
    RECEIVE: (1, receive(beacon_of().SerializeToString())),
    BEACON: (2, beacon_of()),
    POSITIONS: (0, pb.Positions(**AT, position=[3, 2, 1])),
    COMMAND: (1, pb.Command(**COMMANDED, mode=pb.MODE_PBCM)),
    LINKS: (0, pb.Links(**AT, frames=frames())),
}
BAD: Final[list[tuple[str, Topic[Any], Any]]] = [
    ("foreign", SENSE, pb.Sense(**AT, vehicle=2)),
    ("mistimed", SENSE, pb.Sense(cycle=K, time_ns=K * T_NS + 1, vehicle=1)),
    ("absurd", SENSE, pb.Sense(**AT, vehicle=1, ahead=pb.Link(gap=NAN))),
    ("absurd", SENSE, pb.Sense(**AT, vehicle=1, position=float("inf"))),
    ("foreign", RECEIVE, receive(vehicle=3)),
    ("mistimed", RECEIVE, receive(time_ns=-1)),
    ("malformed", RECEIVE, receive(b"", source=[])),
    ("malformed", RECEIVE, receive(b"", arrived_ns=[1, 2])),
    ("malformed", RECEIVE, receive(beacon=[b"", b""])),
    ("absurd", RECEIVE, receive(b"\xff")),
    ("absurd", RECEIVE, receive(beacon_of(3).SerializeToString())),
    ("absurd", RECEIVE, receive(beacon_of(speed=NAN).SerializeToString())),
    ("absurd", RECEIVE, receive(beacon_of(time_ns=(K + 1) * T_NS).SerializeToString())),
    ("foreign", BEACON, beacon_of(3)),
    ("mistimed", BEACON, beacon_of(time_ns=0)),
    ("malformed", BEACON, beacon_of(planned_from_ns=[1, 2])),
    ("malformed", BEACON, beacon_of(planned_from_ns=[], planned_acceleration=[])),
    ("absurd", BEACON, beacon_of(planned_acceleration=[NAN])),
    ("absurd", BEACON, beacon_of(sequence=2**32 - 1)),
    ("mistimed", POSITIONS, pb.Positions(cycle=K, position=[3, 2, 1])),
    ("malformed", POSITIONS, pb.Positions(**AT, position=[3, 2])),
    ("absurd", POSITIONS, pb.Positions(**AT, position=[3, NAN, 1])),
    ("foreign", COMMAND, pb.Command(**{**COMMANDED, "vehicle": 2**32 - 1})),
    ("mistimed", COMMAND, pb.Command(**{**COMMANDED, "time_ns": 1})),
    ("mistimed", COMMAND, pb.Command(**{**COMMANDED, "effective_ns": 0})),
    ("absurd", COMMAND, pb.Command(**{**COMMANDED, "acceleration": NAN})),
    ("mistimed", LINKS, pb.Links(cycle=K, frames=frames())),
    ("malformed", LINKS, pb.Links(**AT)),
    ("mistimed", LINKS, pb.Links(**AT, frames=frames(cycle=K + 1))),
    ("malformed", LINKS, pb.Links(**AT, frames=b"\xff\xff")),
    ("malformed", LINKS, pb.Links(**AT, frames=frames(latency_ns=[]))),
    ("malformed", LINKS, pb.Links(**AT, frames=frames(hops=[1, 1]))),
    ("malformed", LINKS, pb.Links(**AT, frames=frames(busy_ratio=[0.5]))),
    ("absurd", LINKS, pb.Links(**AT, frames=frames(source=[0]))),
    ("absurd", LINKS, pb.Links(**AT, frames=frames(destination=[SIZE + 1]))),
    ("absurd", LINKS, pb.Links(**AT, frames=frames(outcome=[99]))),
]


def reader(topic: Topic[Any], folder: Path) -> Agent:
    scenario = scenario_of(folder, f"duration_s: 3\n{FLEET}")
    roles: dict[str | None, Agent] = {
        "world": LockStepWorld(scenario),
        "channel": LockStepChannel(scenario),
        "vehicle": LockStepVehicle(scenario, 1),
    }
    return roles[topic.reader]


@pytest.mark.parametrize(("reason", "topic", "message"), BAD)
def test_what_makes_no_sense_does_not_keep_the_real_one_out(
    tmp_path: Path, reason: str, topic: Topic[Any], message: Any
) -> None:
    mailbox = Mailbox(reader(topic, tmp_path).fault_in)
    vehicle, good = GOOD[topic]
    assert mailbox.put(topic, vehicle, message.SerializeToString()) == reason
    assert mailbox.put(topic, vehicle, good.SerializeToString()) is None
    assert mailbox.put(topic, vehicle, good.SerializeToString()) == "duplicate"
    assert mailbox.rejected == Counter([reason, "duplicate"])


def test_an_unknown_mode_is_refused(tmp_path: Path) -> None:
    """Protobuf keeps any number in an enum, also one that no column of the log can hold."""
    payload = pb.Command(**COMMANDED).SerializeToString() + b"\x30" + b"\xff" * 9 + b"\x01"
    assert pb.Command.FromString(payload).mode == -1
    assert Mailbox(reader(COMMAND, tmp_path).fault_in).put(COMMAND, 1, payload) == "absurd"


@pytest.mark.parametrize("cycle", [WINDOW, WINDOW + 1, 10**9, 2**32 - 1])
def test_what_is_of_a_cycle_that_cannot_have_begun_is_not_kept(cycle: int) -> None:
    mailbox = Mailbox()
    message = pb.Positions(cycle=cycle).SerializeToString()
    assert mailbox.put(POSITIONS, 0, message) == "early"
    last = pb.Positions(cycle=WINDOW - 1).SerializeToString()
    assert mailbox.put(POSITIONS, 0, last) is None


def test_in_real_time_a_report_of_the_clock_is_looked_at(tmp_path: Path) -> None:
    world = RealtimeWorld(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"))

    def fault(**timing: Any) -> str | None:
        command = pb.Command(**COMMANDED, timing=pb.Timing(**timing))
        return world.fault_in(COMMAND, 1, command)

    assert fault() is None
    assert fault(source=[2], arrived_ns=[1], came_ns=[2]) is None
    assert fault(source=[2], arrived_ns=[1]) == "malformed"
    assert fault(source=[SIZE + 1], arrived_ns=[1], came_ns=[2]) == "absurd"


def test_in_real_time_frames_are_the_fleets_and_have_arrived(tmp_path: Path) -> None:
    vehicle = RealtimeVehicle(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"), 1)
    good = beacon_of().SerializeToString()
    row = {"time_ns": K * T_NS + 1, "arrived_ns": [K * T_NS + 1]}
    assert vehicle.fault_in(RECEIVE, 1, receive(good, **row)) is None
    for change in ({"arrived_ns": [2**62]}, {"arrived_ns": [0]}, {"source": [77]}):
        assert vehicle.fault_in(RECEIVE, 1, receive(good, **{**row, **change})) == "absurd"


def test_in_real_time_no_frame_comes_twice(tmp_path: Path) -> None:
    vehicle = RealtimeVehicle(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"), 1)

    def hears(arrived_ns: int, *sequences: int) -> bool:
        beacons = [beacon_of(sequence=sequence).SerializeToString() for sequence in sequences]
        message = receive(*beacons, arrived_ns=[arrived_ns] * len(beacons))
        return vehicle.take_in(Post(RECEIVE, 1, message, b"", arrived_ns)) is None

    assert hears(10**9, 1, 2)
    assert not hears(10**9, 1, 2)
    assert not hears(10**9, 2)
    assert not hears(10**9, 3)  # another content is no other frame
    assert hears(10**9 + 1, 1)
    assert hears(6 * 10**9, 5)
    assert not hears(10**9, 4)  # too old to tell


def test_in_real_time_no_table_of_frames_is_told_of_twice(tmp_path: Path) -> None:
    world = RealtimeWorld(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"))
    while world.due_ns <= K * T_NS:
        world.act(world.due_ns)

    def hears(payload: bytes) -> bool:
        return world.take_in(Post(LINKS, 0, pb.Links(**AT, frames=payload), b"", K * T_NS)) is None

    assert hears(frames())
    assert not hears(frames())
    assert hears(frames(source=[3]))
    assert not hears(frames(source=[3], destination=[1]))


def test_in_real_time_positions_of_a_cycle_count_once(tmp_path: Path) -> None:
    channel = RealtimeChannel(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"))

    def hears(cycle: int) -> bool:
        return channel.take_in(Post(POSITIONS, 0, pb.Positions(cycle=cycle), b"", 0)) is None

    assert [hears(cycle) for cycle in (6, 6, 7, 5, 1)] == [True, False, True, True, False]


def test_each_kind_and_source_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    refusals = Refusals("world")
    for _ in range(3):
        refusals.add("stale", "a/b")
        refusals.add("early", "a/b")
        refusals.add("stale", "a/\nworld: all is well")
    refusals.report_counts()
    assert capsys.readouterr().err.splitlines() == [
        "world: refused: stale, on 'a/b'",
        "world: refused: early, on 'a/b'",
        r"world: refused: stale, on 'a/\nworld: all is well'",
        "world: messages refused: 3 early, 6 stale",
    ]


def test_what_is_told_has_an_end(capsys: pytest.CaptureFixture[str]) -> None:
    refusals = Refusals("world")
    for number in range(1_000):
        refusals.add("foreign", f"{number}/" + 1_000 * "x")
    refusals.report_counts()
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == MOST_LINES
    assert max(map(len, lines)) < 200
    assert lines[-1] == "world: messages refused: 1000 foreign"


def test_nothing_is_told_where_nothing_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Refusals("world").report_counts()
    assert capsys.readouterr().err == ""


def test_the_attack_begins_when_there_is_something_to_be_stale() -> None:
    assert FIRST_CYCLE > WINDOW
