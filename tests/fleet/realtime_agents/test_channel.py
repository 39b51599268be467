"""The channel's agent waits for beacons as long as frames can still arrive in time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.fleet.realtime_agents.one_agent import due, post
from tests.fleet.realtime_agents.runs import MS, QUIET, scenario
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS, Topic
from zenvoy.channel.realtime import RealtimeChannel


def beacons_to(channel: RealtimeChannel, size: int) -> Callable[..., None]:
    """Return a function that gives the channel positions, or a cycle's beacons of vehicles."""

    def give(topic: Topic[Any], cycle: int, *vehicles: int, came_ns: int = 0) -> None:
        for vehicle in vehicles:
            stamp: dict[str, Any] = {"cycle": cycle, "time_ns": cycle * 100 * MS}
            message = pb.Beacon(**stamp, vehicle=vehicle, sequence=cycle)
            if topic is POSITIONS:
                places = pb.Positions(**stamp, position=range(20 * size, 0, -20))
                assert channel.take_in(post(topic, 0, came_ns, places)) is None
            else:
                assert channel.take_in(post(topic, vehicle, came_ns, message)) is None

    return give


def test_the_channel_waits_longer_if_many_beacons_are_missing(
    tmp_path: Path,
) -> None:
    channel = RealtimeChannel(scenario(tmp_path, QUIET.replace("size: 4", "size: 8")))
    give = beacons_to(channel, size=8)
    give(POSITIONS, 0, 0)
    give(BEACON, 0, 1, 2, 3, 4)
    assert due(channel) == 19.4 * MS
    give(BEACON, 0, 5)
    assert due(channel) == 7.4 * MS  # three missing ones do not mean a slow machine
    give(BEACON, 0, 6, 7, 8)
    assert due(channel) == 0


@pytest.mark.parametrize(("in_time", "airs_ms"), [(6, 17), (7, 12)])
def test_late_beacons_wait_for_others_that_are_late(
    tmp_path: Path, in_time: int, airs_ms: int
) -> None:
    channel = RealtimeChannel(scenario(tmp_path, QUIET.replace("size: 4", "size: 8")))
    give = beacons_to(channel, size=8)
    give(POSITIONS, 0, 0)
    give(BEACON, 0, *range(1, in_time + 1))
    (links,) = channel.act(8 * MS)
    assert links.topic is LINKS
    assert channel.act(8 * MS) == []  # it prepares what it delivers next
    assert len(channel.act(11 * MS)) == 8
    assert due(channel) is None
    give(BEACON, 0, 8, came_ns=12 * MS)
    assert due(channel) == airs_ms * MS


def test_the_channel_waits_until_the_guard_time_for_vehicles_that_sent_last_time(
    tmp_path: Path,
) -> None:
    channel = RealtimeChannel(scenario(tmp_path, QUIET))
    give = beacons_to(channel, size=4)

    def frames() -> set[int]:
        """Return the sources of the frames that the channel sends now."""
        (links,) = channel.act(channel.due_ns or 0)
        return set(pb.Frames.FromString(pb.Links.FromString(links.payload).frames).source)

    give(BEACON, 0, 1, 2)
    assert due(channel) is None  # the range is unknown without positions
    give(POSITIONS, 0, 0)
    assert due(channel) == 7.4 * MS  # 3 ms before the first frame arrives
    give(BEACON, 0, 3)
    assert frames() == {1, 2, 3}
    assert channel.act(8 * MS) == []  # it prepares what it delivers next
    assert due(channel) == 10.4 * MS
    give(BEACON, 0, 4, came_ns=7 * MS)  # later than the others
    assert frames() == {4}  # at once, since no others are late
    assert channel.act(9 * MS) == []
    receives = channel.act(10 * MS + 400_000)
    assert [envelope.vehicle for envelope in receives] == [1, 2, 3, 4]
    assert [len(pb.Receive.FromString(r.payload).source) for r in receives] == [3, 3, 3, 3]
    give(POSITIONS, 1, 0)
    give(BEACON, 1, 1, 2, 3)
    assert due(channel) == 107.4 * MS
    assert frames() == {1, 2, 3}
    while channel.due_ns is not None:
        channel.act(channel.due_ns)
    give(POSITIONS, 2, 0)
    give(BEACON, 2, 1, 2, 3)
    assert due(channel) == 200 * MS  # 4 did not send last time
    assert channel.take_in(post(BEACON, 2, 0, pb.Beacon(cycle=2, vehicle=2))) == "stale"
