"""Damaged frames, second copies and the order of frames, as vehicles and the log see them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.channel.ring_of_thirty import FRAMES, POSITION, S_NS, SIZE, Ints, scenario, within
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS, RECEIVE
from zenvoy.channel.in_order import InOrder
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.links.sent_frames import SentFrames
from zenvoy.scenarios import Channel, Latency, Loss


class Ran(NamedTuple):
    """Reported frames by receiver, their arrivals (ns) and outcomes, and how often each arrives."""

    reported: SentFrames
    arrived_ns: Ints
    outcome: Ints
    heard: dict[tuple[int, int, int], int]


def run(channel: Channel, cycles: int = 40) -> Ran:
    settings = scenario(channel, cycles)
    agent, mailbox = LockStepChannel(settings), Mailbox()
    columns: list[dict[str, Ints]] = []
    heard: dict[tuple[int, int, int], int] = {}
    for cycle in range(cycles):
        for vehicle in range(1, SIZE + 1):
            beacon = pb.Beacon(cycle=cycle, time_ns=cycle * S_NS // 10, vehicle=vehicle)
            beacon.sequence = cycle
            mailbox.put(BEACON, vehicle, beacon.SerializeToString())
        positions = pb.Positions(cycle=cycle, time_ns=cycle * S_NS // 10, position=POSITION)
        mailbox.put(POSITIONS, 0, positions.SerializeToString())
        barrier = agent.barrier
        assert barrier is not None
        for envelope in agent.step(barrier.now_ns, mailbox.take(barrier)):
            if envelope.topic is LINKS:
                columns.append(FRAMES.decode(LINKS.decode(envelope.payload).frames))
            elif envelope.topic is RECEIVE:
                receive = RECEIVE.decode(envelope.payload)
                assert list(receive.arrived_ns) == sorted(receive.arrived_ns)
                for source, payload in zip(receive.source, receive.beacon, strict=True):
                    frame = (source, receive.vehicle, pb.Beacon.FromString(payload).sequence)
                    heard[frame] = heard.get(frame, 0) + 1
    names = ("source", "destination", "distance", "sequence", "arrived_ns", "outcome")
    table = {name: np.concatenate([column[name] for column in columns]) for name in names}
    reported = SentFrames(
        table["source"].astype(np.int64) - 1,
        table["destination"].astype(np.int64) - 1,
        table["distance"].astype(np.float64),
        table["sequence"].astype(np.int64),
    )
    return Ran(reported, table["arrived_ns"], table["outcome"], heard)


def test_damaged_frames_are_reported_and_not_heard() -> None:
    reported, arrived_ns, outcome, heard = run(Channel(loss=Loss(corrupt=0.2)))
    damaged = outcome == pb.OUTCOME_CORRUPTED
    assert within(damaged.mean(), 0.2, len(damaged))
    assert (arrived_ns[damaged] == -1).all()
    assert len(heard) == (~damaged).sum()
    assert reported.source.size == SIZE * (SIZE - 1) * 40


def test_second_copies_are_reported_and_heard() -> None:
    channel = Channel(
        duplicate=0.25,
        loss=Loss(p=0.1),
        latency=Latency(distribution="uniform", min_ms=1.0, max_ms=15.0),
    )
    reported, arrived_ns, outcome, heard = run(channel)
    second = outcome == pb.OUTCOME_DUPLICATE
    first = outcome == pb.OUTCOME_DELIVERED
    assert within(second.sum() / first.sum(), 0.25, int(first.sum()))
    assert (arrived_ns[second] > 0).all()
    assert sum(heard.values()) == first.sum() + second.sum()
    assert set(heard.values()) == {1, 2}
    at = {
        (*frame, copy): ns
        for *frame, copy, ns in zip(
            reported.source.tolist(), reported.destination.tolist(), reported.sequence.tolist(),
            second.tolist(), arrived_ns.tolist(), strict=True,
        )
    }  # fmt: skip
    gaps = [at[*frame, False] - ns for *frame, copy, ns in
            ((*key, value) for key, value in at.items()) if copy]  # fmt: skip
    assert min(gaps) < 0 < max(gaps)  # either may come first


@pytest.mark.parametrize("reorder", [True, False])
def test_frames_overtake_only_if_reordering_is_on(reorder: bool) -> None:
    latency = Latency(distribution="uniform", min_ms=10.0, max_ms=350.0, reorder=reorder)
    reported, arrived_ns, _, _ = run(Channel(latency=latency))
    link = reported.source * SIZE + reported.destination
    order = np.lexsort((reported.sequence, link))
    same = np.diff(link[order]) == 0
    gaps = np.diff(arrived_ns[order])[same]
    assert (gaps < 0).any() == reorder


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(-1, 50), st.booleans()), max_size=30))
def test_only_ordered_frames_are_held(arrivals: list[tuple[int, int, bool]]) -> None:
    held_back = InOrder(4)
    newest: dict[int, int] = {}
    for source, arrival, ordered in arrivals:
        (held,) = held_back.held(
            np.array([source]), np.array([0]), np.array([arrival]), np.array([ordered])
        ).tolist()
        if arrival < 0 or not ordered:
            assert held == arrival
        else:
            assert held == max(arrival, newest.get(source, 0))
        newest[source] = max(newest.get(source, 0), held)
