"""The channel, as an agent, delivers each frame to its receiver once, and never too early."""

from __future__ import annotations

from collections import Counter
from typing import Literal, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS, RECEIVE
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.scenarios import Channel, Control, Fleet, Loss, Road, Scenario, technologies

T_NS = 100_000_000
MS_NS = 1_000_000
FRAMES = PackedCodec(pb.Frames.DESCRIPTOR)

Frame = tuple[int, int, int]  # source, destination, sequence number


class Heard(NamedTuple):
    cycle: int
    arrived_ns: int


class Fate(NamedTuple):
    """The outcome of a frame, as the log has it."""

    arrived_ns: int
    latency_ns: int
    outcome: int


class Air:
    """Drives the channel through a whole run and keeps what it sends."""

    def __init__(self, scenario: Scenario, gap_m: float) -> None:
        self.size, self.cycles = scenario.fleet.size, scenario.cycles
        self.wait_ns = scenario.v2v_wait_ns
        self.heard: dict[Frame, Heard] = {}
        self.order: list[pb.Receive] = []
        self.links: list[pb.Links] = []
        self.fate: dict[Frame, Fate] = {}
        position = np.arange(self.size - 1.0, -1.0, -1.0) * gap_m
        agent, mailbox = LockStepChannel(scenario), Mailbox()
        for cycle in range(self.cycles):
            self._drain(agent, mailbox)
            for vehicle in range(1, self.size + 1):
                mailbox.put(BEACON, vehicle, self.beacon(vehicle, cycle).SerializeToString())
            report = pb.Positions(cycle=cycle, time_ns=cycle * T_NS, position=position.tolist())
            mailbox.put(POSITIONS, 0, report.SerializeToString())
        self._drain(agent, mailbox)
        assert agent.barrier is None
        assert mailbox.rejected.total() == 0

    @staticmethod
    def beacon(vehicle: int, cycle: int) -> pb.Beacon:
        return pb.Beacon(
            cycle=cycle,
            time_ns=cycle * T_NS,
            vehicle=vehicle,
            sequence=cycle,
            speed=30.0 + vehicle,
            planned_from_ns=[cycle * T_NS],
            planned_acceleration=[0.1 * cycle],
        )

    def _drain(self, agent: LockStepChannel, mailbox: Mailbox) -> None:
        while (barrier := agent.barrier) is not None and mailbox.met(barrier):
            for envelope in agent.step(barrier.now_ns, mailbox.take(barrier)):
                self._take(envelope)

    def _take(self, envelope: Envelope) -> None:
        if envelope.topic is LINKS:
            links = LINKS.decode(envelope.payload)
            self.links.append(links)
            table = {name: column.tolist() for name, column in FRAMES.decode(links.frames).items()}
            names = ("source", "destination", "sequence", "arrived_ns", "latency_ns", "outcome")
            rows = zip(*(table[name] for name in names), strict=True)
            for source, destination, sequence, *fate in rows:
                frame = (source, destination, sequence)
                assert frame not in self.fate
                self.fate[frame] = Fate(*fate)
            return
        assert envelope.topic is RECEIVE
        receive = RECEIVE.decode(envelope.payload)
        assert envelope.vehicle == receive.vehicle
        self.order.append(receive)
        heard = zip(receive.source, receive.arrived_ns, receive.beacon, strict=True)
        for source, arrived_ns, payload in heard:
            beacon = pb.Beacon.FromString(payload)
            assert beacon == self.beacon(source, beacon.cycle)  # as it was sent
            frame = (source, receive.vehicle, beacon.sequence)
            assert frame not in self.heard, "delivered twice"
            self.heard[frame] = Heard(receive.cycle, arrived_ns)


def scenario(
    *,
    technology: str,
    wait_ms: float,
    loss: float = 0.0,
    size: int = 5,
    seed: int = 1,
    ring: bool = True,
    cycles: int = 12,
) -> Scenario:
    return Scenario(
        duration_s=cycles * 0.1,
        seed=seed,
        road=Road(type="ring" if ring else "open"),
        fleet=Fleet(size=size),
        control=Control(v2v_wait_ms=wait_ms),
        channel=Channel(technology=technologies()[technology], loss=Loss(p=loss)),
    )


def check(air: Air) -> None:
    """Check that each frame is lost, or delivered once in the first delivery after its arrival."""
    assert [links.cycle for links in air.links] == list(range(air.cycles))
    vehicles = range(1, air.size + 1)
    assert Counter((receive.cycle, receive.vehicle) for receive in air.order) == Counter(
        (cycle, vehicle) for cycle in range(air.cycles) for vehicle in vehicles
    )
    for receive in air.order:
        until_ns = receive.cycle * T_NS + air.wait_ns
        assert receive.time_ns == until_ns
        assert list(receive.arrived_ns) == sorted(receive.arrived_ns)
        assert all(until_ns - T_NS < ns <= until_ns for ns in receive.arrived_ns)
    for frame, fate in air.fate.items():
        sent_ns = frame[2] * T_NS
        arrived_ns, latency_ns, outcome = fate
        if outcome in {pb.OUTCOME_LOST, pb.OUTCOME_OUT_OF_RANGE}:
            assert arrived_ns == latency_ns == -1
            assert frame not in air.heard
            continue
        assert arrived_ns == sent_ns + latency_ns
        due = -(-(arrived_ns - air.wait_ns) // T_NS)  # first cycle to end after the arrival
        if due < air.cycles:
            assert air.heard[frame] == (due, arrived_ns)
        else:
            assert frame not in air.heard  # the run has ended before
        first = frame[2] + (0 if air.wait_ns else 1)
        assert outcome == (pb.OUTCOME_DELIVERED if due == first else pb.OUTCOME_LATE)
    assert set(air.heard) <= set(air.fate)


@settings(deadline=None, max_examples=40)
@given(
    technology=st.sampled_from(["ieee80211p", "lte-a-pro", "5g-mmwave"]),
    wait_ms=st.sampled_from([0.0, 5.0, 10.4, 11.0, 25.0, 50.0, 99.0]),
    loss=st.sampled_from([0.0, 0.3, 1.0]),
    ring=st.booleans(),
    seed=st.integers(0, 2**63 - 1),
)
def test_every_frame_is_delivered_once_or_lost(
    technology: Literal["ieee80211p", "lte-a-pro", "5g-mmwave"],
    wait_ms: float,
    loss: float,
    ring: bool,
    seed: int,
) -> None:
    settings_of_run = scenario(
        technology=technology, wait_ms=wait_ms, loss=loss, ring=ring, seed=seed
    )
    check(Air(settings_of_run, 37.5))


def test_slow_frames_come_with_a_later_cycle() -> None:
    """LTE-A Pro takes 20 to 80 ms, so half of the frames arrive within 50 ms."""
    air = Air(scenario(technology="lte-a-pro", wait_ms=50.0, cycles=40), 37.5)
    check(air)
    outcomes = Counter(fate.outcome for fate in air.fate.values())
    assert outcomes[pb.OUTCOME_DELIVERED] + outcomes[pb.OUTCOME_LATE] == 40 * 20
    assert outcomes[pb.OUTCOME_LATE] == pytest.approx(400, abs=3 * 14.2)  # √(800/4)
    overtaken = [
        receive
        for receive in air.order
        if [pb.Beacon.FromString(payload).cycle for payload in receive.beacon]
        != sorted(pb.Beacon.FromString(payload).cycle for payload in receive.beacon)
    ]
    assert overtaken == []  # within a delivery, old frames come first, since they arrived first


def test_a_frame_that_arrives_just_at_the_end_of_the_wait_is_delivered() -> None:
    """The latency is 10 ms of delay and 0.4 ms on the air."""
    for wait_ms, later in ((10.4, 0), (10.399999, 1)):
        air = Air(scenario(technology="ieee80211p", wait_ms=wait_ms), 37.5)
        check(air)
        assert {heard.cycle - frame[2] for frame, heard in air.heard.items()} == {later}


def test_without_a_wait_all_frames_come_with_the_next_cycle() -> None:
    air = Air(scenario(technology="ieee80211p", wait_ms=0.0), 37.5)
    check(air)
    assert {sequence + 1 for _, _, sequence in air.heard} == {
        heard.cycle for heard in air.heard.values()
    }
    assert {fate.outcome for fate in air.fate.values()} == {pb.OUTCOME_DELIVERED}
    assert not any(receive.beacon for receive in air.order if receive.cycle == 0)


def test_without_a_wait_a_delivery_does_not_depend_on_the_beacons_of_its_cycle() -> None:
    """So the channel sends it before they come, and vehicles need not wait for each other."""
    agent = LockStepChannel(scenario(technology="ieee80211p", wait_ms=0.0))
    barrier = agent.barrier
    assert barrier is not None
    assert barrier.needs == ()
    first = agent.step(barrier.now_ns, Mailbox().take(barrier))
    assert [envelope.topic for envelope in first] == [RECEIVE] * 5


def test_vehicles_out_of_range_hear_nothing() -> None:
    air = Air(scenario(technology="5g-mmwave", wait_ms=11.0, ring=False), 60.0)
    check(air)
    assert air.heard == {}
    assert len(air.fate) == 12 * 8  # each neighbour still has a row
    assert {fate.outcome for fate in air.fate.values()} == {pb.OUTCOME_OUT_OF_RANGE}


def test_a_frame_that_outlives_many_cycles_is_kept() -> None:
    """300 bytes at 10 kbit/s take 240 ms on the air, so frames of three cycles are in flight."""
    settings_of_run = scenario(technology="ieee80211p", wait_ms=11.0)
    slow = settings_of_run.model_copy(
        update={"channel": Channel(technology=technologies()["ieee80211p"], bit_rate_mbps=0.01)}
    )
    air = Air(slow, 37.5)
    check(air)
    assert {fate.latency_ns for fate in air.fate.values()} == {250 * MS_NS}
    assert {heard.cycle - frame[2] for frame, heard in air.heard.items()} == {3}
