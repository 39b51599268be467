"""Rules, loss by distance, damage, duplicates and reordering do what the scenario says."""

from __future__ import annotations

from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.refused import refused
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS, RECEIVE
from zenvoy.channel.conditions import Conditions, Impairments
from zenvoy.channel.in_order import InOrder
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import (
    Channel,
    Control,
    Fleet,
    GilbertElliott,
    Latency,
    Loss,
    Rule,
    Scenario,
    technologies,
)

Ints = NDArray[np.int64]

SIZE: Final = 30
S_NS: Final = 1_000_000_000
MS_NS: Final = 1_000_000
GAP_M: Final = 20.0
POSITION: Final = np.arange(SIZE - 1, -1, -1.0) * GAP_M  # on a ring of 600 m, vehicle 1 ahead
SOURCE, DESTINATION = (
    index[~np.eye(SIZE, dtype=bool)] for index in np.indices((SIZE, SIZE), dtype=np.int64)
)
AROUND: Final = np.mod(POSITION[SOURCE] - POSITION[DESTINATION], 600.0)
DISTANCE: Final = np.minimum(AROUND, 600.0 - AROUND)
FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)


def scenario(channel: Channel, cycles: int = 40) -> Scenario:
    return Scenario(
        duration_s=cycles * 0.1,
        fleet=Fleet(size=SIZE, gap_m=GAP_M),
        control=Control(v2v_wait_ms=20.0),
        channel=channel,
    )


def frames(sequence: int) -> SentFrames:
    return SentFrames(SOURCE, DESTINATION, DISTANCE, np.full(len(SOURCE), sequence))


def ways(channel: Channel, count: int = 60) -> Impairments:
    """Return the impairments, (count, links), of frames that each link sends every 0.1 s."""
    conditions = Conditions(scenario(channel))
    found = [
        conditions.of(frames(n), Scene(n, n * S_NS // 10, POSITION, 600.0)) for n in range(count)
    ]
    return Impairments(*map(np.array, zip(*found, strict=True)))


def within(share: float, p: float, n: int) -> bool:
    """Return whether a share of n lies in the 99 % interval about p."""
    return bool(abs(share - p) <= 2.58 * np.sqrt(p * (1.0 - p) / n))


def test_loss_by_distance_is_linear_between_its_points() -> None:
    table = ((50.0, 0.0), (150.0, 0.4), (250.0, 0.6))
    lost = ways(Channel(loss=Loss(by_distance=table)), count=400).lost
    for metres, p in ((20.0, 0.0), (60.0, 0.04), (100.0, 0.2), (200.0, 0.5), (300.0, 0.6)):
        there = lost[:, np.isclose(DISTANCE, metres)]
        assert within(there.mean(), p, there.size), metres


def test_loss_by_distance_adds_to_independent_loss() -> None:
    loss = Loss(p=0.5, by_distance=((0.0, 0.2),))
    lost = ways(Channel(loss=loss), count=200).lost
    assert within(lost.mean(), 1.0 - 0.5 * 0.8, lost.size)


def test_damaged_frames_are_not_lost_frames() -> None:
    way = ways(Channel(loss=Loss(p=0.3, corrupt=0.1)), count=200)
    assert within(way.damaged.mean(), 0.1, way.damaged.size)
    assert within(way.damaged[way.lost].mean(), 0.1, int(way.lost.sum()))


def test_the_last_rule_that_applies_wins() -> None:
    rules = (
        Rule(from_s=1.0, until_s=2.0, loss=Loss(p=1.0)),
        Rule(source="1", loss=Loss(), latency=Latency(distribution="fixed", mean_ms=50.0)),
        Rule(destination="2", latency=Latency(distribution="fixed", mean_ms=70.0)),
    )
    way = ways(Channel(loss=Loss(p=0.0), rules=rules))
    during = np.zeros(60, dtype=bool)
    during[10:20] = True
    first = SOURCE == 0
    assert way.lost[during][:, ~first].all()
    assert not way.lost[:, first].any()  # its rule has its own loss, which is none
    assert not way.lost[~during].any()
    second = DESTINATION == 1
    assert (way.latency_ns[:, second] == 70 * MS_NS).all()
    assert (way.latency_ns[:, first & ~second] == 50 * MS_NS).all()
    assert (way.latency_ns[:, ~first & ~second] == 10 * MS_NS).all()


def test_a_rule_on_a_stretch() -> None:
    rule = Rule(from_m=580.0, to_m=10.0, loss=Loss(p=1.0))  # over the seam: vehicles 1 and 30
    lost = ways(Channel(rules=(rule,)), count=1).lost[0]
    ends = np.isin(SOURCE, (0, 29)) | np.isin(DESTINATION, (0, 29))
    np.testing.assert_array_equal(lost, ends)


def test_a_rule_equal_to_the_channel_changes_nothing() -> None:
    bursts = Loss(p=0.2, corrupt=0.1)
    latency = Latency(distribution="gamma", mean_ms=20.0, std_ms=5.0)
    plain = Channel(loss=bursts, latency=latency)
    ruled = Channel(loss=Loss(p=0.9), rules=(Rule(loss=bursts, latency=latency),))
    for one, other in zip(ways(plain), ways(ruled), strict=True):
        np.testing.assert_array_equal(one, other)


def test_each_rule_has_its_own_bursts() -> None:
    bursts = Loss(gilbert_elliott=GilbertElliott(p=0.1, r=0.3))
    plain = ways(Channel(loss=bursts), count=300).lost
    ruled = ways(Channel(rules=(Rule(loss=bursts),)), count=300).lost
    assert 0.2 < plain.mean() < 0.3
    assert 0.2 < ruled.mean() < 0.3
    assert abs(np.corrcoef(plain.ravel(), ruled.ravel())[0, 1]) < 0.01


def test_a_rule_does_not_change_the_draws_of_other_links() -> None:
    loss = Loss(p=0.3, gilbert_elliott=GilbertElliott(p=0.05, r=0.5))
    plain = ways(Channel(technology=technologies()["lte-a-pro"], loss=loss))
    rule = Rule(source="3", loss=Loss(p=0.9), latency=Latency(distribution="fixed", mean_ms=1.0))
    ruled = ways(Channel(technology=technologies()["lte-a-pro"], loss=loss, rules=(rule,)))
    others = SOURCE != 2
    for one, other in zip(plain, ruled, strict=True):
        np.testing.assert_array_equal(one[:, others], other[:, others])
    assert (plain.lost[:, ~others] != ruled.lost[:, ~others]).any()


# Through the channel's agent: the frames that it reports, and those that vehicles hear.


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


@pytest.mark.parametrize(
    ("channel", "line"),
    [
        ("{loss: {by_distance: [[100, 0], [100, 1]]}}",
         "channel.loss.by_distance.1.0: 100 is not greater than the distance before (100)"),
        ("{loss: {by_distance: [[100, 2]]}}", "channel.loss.by_distance.0.1: 2 is not in [0, 1]"),
        ("{duplicate: -1}", "channel.duplicate: -1 is not in [0, 1]"),
        ("{rules: [{loss: {p: 2}}]}", "channel.rules.0.loss.p: 2 is not in [0, 1]"),
        ("{rules: [{}, {latency: {distribution: fixed}}]}",
         "channel.rules.1.latency.mean_ms: missing; channel.rules.1.latency.distribution is fixed"),
        ("{rules: [{source: 41}]}", "channel.rules.0.source: "),
        ("{rules: [{until_s: 3, from_s: 3}]}",
         "channel.rules.0.until_s: 3 is not later than channel.rules.0.from_s (3)"),
        ("{rules: [{los: 3}]}", "channel.rules.0.los: unknown key; did you mean 'loss'?"),
    ],
)  # fmt: skip
def test_wrong_settings_are_refused(tmp_path: Path, channel: str, line: str) -> None:
    (found,) = refused(tmp_path, f"channel: {channel}\n")
    assert found.startswith(line)
