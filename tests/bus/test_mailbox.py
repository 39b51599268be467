"""The inbox does not depend on the order of messages. Refused messages do not change it."""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier
from zenvoy.bus.mailbox import WINDOW, Mailbox
from zenvoy.bus.refusals import DUPLICATE, EARLY, STALE
from zenvoy.bus.topics import BEACON, POSITIONS, Topic

VEHICLES, CYCLES = (1, 2, 3), 3


class Post(NamedTuple):
    topic: Topic[Any]
    vehicle: int
    payload: bytes


def beacon(vehicle: int, cycle: int, speed: float = 30.0) -> Post:
    message = pb.Beacon(cycle=cycle, vehicle=vehicle, speed=speed)
    return Post(BEACON, vehicle, message.SerializeToString())


def positions(cycle: int) -> Post:
    return Post(POSITIONS, 0, pb.Positions(cycle=cycle, position=[cycle]).SerializeToString())


def barrier(cycle: int) -> Barrier:
    return Barrier(cycle * 100, cycle, ((BEACON, VEHICLES), (POSITIONS, (0,))))


ALL = [
    post
    for cycle in range(CYCLES)
    for post in (*(beacon(vehicle, cycle) for vehicle in VEHICLES), positions(cycle))
]


def check_taken(mailbox: Mailbox, cycle: int) -> None:
    inbox = mailbox.take(barrier(cycle))
    assert [message.vehicle for message in inbox.all(BEACON)] == list(VEHICLES)
    assert {(message.cycle, message.speed) for message in inbox.all(BEACON)} == {(cycle, 30.0)}
    assert inbox.one(POSITIONS) == pb.Positions(cycle=cycle, position=[cycle])


@given(st.permutations(ALL))
def test_any_order_gives_the_same_inbox(posts: list[Post]) -> None:
    """The test takes each cycle as soon as it is complete, as a bus does."""
    mailbox, cycle, here = Mailbox(), 0, set()
    for post in posts:
        mailbox.put(*post)
        here.add(post)
        while cycle < CYCLES and mailbox.met(barrier(cycle)):
            assert here >= set(ALL[4 * cycle : 4 * cycle + 4])
            check_taken(mailbox, cycle)
            cycle += 1
    assert cycle == CYCLES
    assert mailbox.rejected.total() == 0


@given(st.permutations(ALL), st.data())
def test_refused_messages_are_counted_and_change_nothing(
    posts: list[Post], data: st.DataObject
) -> None:
    mailbox, cycle, expected = Mailbox(), 0, {"malformed": 0, "stale": 0, "duplicate": 0}
    seen: list[tuple[int, int]] = []
    for post in posts:
        kind = data.draw(st.sampled_from(["none", "malformed", "again"]))
        if kind == "malformed":
            mailbox.put(BEACON, data.draw(st.sampled_from(VEHICLES)), b"\xff\xff\xff")
            expected["malformed"] += 1
        elif kind == "again" and seen:
            vehicle, of_cycle = data.draw(st.sampled_from(seen))
            mailbox.put(*beacon(vehicle, of_cycle, speed=-1.0))
            expected["stale" if of_cycle < cycle else "duplicate"] += 1
        mailbox.put(*post)
        if post.topic is BEACON:
            message = pb.Beacon.FromString(post.payload)
            seen.append((message.vehicle, message.cycle))
        while cycle < CYCLES and mailbox.met(barrier(cycle)):
            check_taken(mailbox, cycle)
            cycle += 1
    assert cycle == CYCLES
    assert {reason: mailbox.rejected[reason] for reason in expected} == expected
    assert mailbox.rejected.total() == sum(expected.values())


def test_missing_messages_are_named() -> None:
    mailbox = Mailbox()
    assert not mailbox.met(barrier(0))
    mailbox.put(*beacon(2, 0))
    mailbox.put(*beacon(1, 1))  # of a later cycle: kept, and of no use yet
    assert mailbox.missing(barrier(0)) == [(BEACON, 1), (BEACON, 3), (POSITIONS, 0)]
    for post in (beacon(1, 0), beacon(3, 0), positions(0)):
        assert not mailbox.met(barrier(0))
        mailbox.put(*post)
    assert mailbox.met(barrier(0))
    assert mailbox.missing(barrier(0)) == []
    assert mailbox.missing(barrier(1)) == [(BEACON, 2), (BEACON, 3), (POSITIONS, 0)]


def test_a_message_is_taken_once() -> None:
    mailbox = Mailbox()
    for post in ALL[:4]:
        mailbox.put(*post)
    mailbox.take(barrier(0))
    assert not mailbox.met(barrier(0))
    mailbox.put(*beacon(1, 0))
    assert mailbox.missing(barrier(0))[0] == (BEACON, 1)
    assert mailbox.rejected == {"stale": 1}


@pytest.mark.parametrize("cycle", [0, 7])
def test_an_empty_barrier_is_met(cycle: int) -> None:
    assert Mailbox().met(Barrier(0, cycle))


@given(
    fates=st.lists(st.sampled_from(["taken", "early", "again", "fits"]), min_size=1, max_size=6),
    vehicles=st.permutations(VEHICLES),
    count=st.integers(1, 3),
)
def test_messages_together_are_kept_as_if_each_had_come_alone(
    fates: list[str], vehicles: list[int], count: int
) -> None:
    """They are kept only if each would be; otherwise they are put one by one."""
    together, alone, cycle = Mailbox(), Mailbox(), 0
    for fate in fates:
        at = {"taken": cycle - 1, "early": cycle + WINDOW, "again": cycle, "fits": cycle}[fate]
        if at < 0:
            continue
        if fate == "again":
            assert together.put(*beacon(vehicles[0], at)) == alone.put(*beacon(vehicles[0], at))
        posts = [beacon(vehicle, at) for vehicle in vehicles[:count]]
        parcels = [(post.vehicle, post.payload) for post in posts]
        reasons = [alone.put(*post) for post in posts]
        kept = together.put_together(BEACON, pb.Beacon(cycle=at), parcels)
        assert kept == (reasons == [None] * count)
        if not kept:
            assert [together.put(*post) for post in posts] == reasons
        expected = {"taken": STALE, "early": EARLY, "again": DUPLICATE, "fits": None}
        assert fate == "fits" or reasons[0] == expected[fate]
        for vehicle in VEHICLES:
            assert together.holds(BEACON, at, vehicle) == alone.holds(BEACON, at, vehicle)
        if fate == "fits":
            for mailbox in (together, alone):
                for post in (*(beacon(one, cycle) for one in VEHICLES), positions(cycle)):
                    mailbox.put(*post)
            assert together.rejected == alone.rejected
            inboxes = [
                mailbox.take(barrier(cycle)).with_payloads(BEACON) for mailbox in (together, alone)
            ]
            payloads = [[payload for _, payload in inbox] for inbox in inboxes]
            assert payloads[0] == payloads[1]
            cycle += 1
