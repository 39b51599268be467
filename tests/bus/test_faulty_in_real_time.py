"""In real time, agents refuse messages that make no sense, and messages that repeat others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.fleet_of_three import (
    AT,
    COMMANDED,
    FLEET,
    SIZE,
    T_NS,
    K,
    beacon_of,
    frames,
    receive,
    scenario_of,
)
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.topics import COMMAND, LINKS, POSITIONS, RECEIVE
from zenvoy.channel.realtime import RealtimeChannel
from zenvoy.vehicles.realtime import RealtimeVehicle
from zenvoy.world.realtime import RealtimeWorld


def test_in_real_time_the_timing_of_a_command_is_checked(tmp_path: Path) -> None:
    world = RealtimeWorld(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"))

    def fault(**timing: Any) -> str | None:
        command = pb.Command(**COMMANDED, timing=pb.Timing(**timing))
        return world.fault_in(COMMAND, 1, command)

    assert fault() is None
    assert fault(source=[2], arrived_ns=[1], came_ns=[2]) is None
    assert fault(source=[2], arrived_ns=[1]) == "malformed"
    assert fault(source=[SIZE + 1], arrived_ns=[1], came_ns=[2]) == "absurd"


def test_in_real_time_frames_of_strangers_or_of_the_future_are_refused(tmp_path: Path) -> None:
    vehicle = RealtimeVehicle(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"), 1)
    good = beacon_of().SerializeToString()
    row = {"time_ns": K * T_NS + 1, "arrived_ns": [K * T_NS + 1]}
    assert vehicle.fault_in(RECEIVE, 1, receive(good, **row)) is None
    for change in ({"arrived_ns": [2**62]}, {"arrived_ns": [0]}, {"source": [77]}):
        assert vehicle.fault_in(RECEIVE, 1, receive(good, **{**row, **change})) == "absurd"


def test_in_real_time_no_frame_is_accepted_twice(tmp_path: Path) -> None:
    vehicle = RealtimeVehicle(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"), 1)

    def accepts(arrived_ns: int, *sequences: int) -> bool:
        beacons = [beacon_of(sequence=sequence).SerializeToString() for sequence in sequences]
        message = receive(*beacons, arrived_ns=[arrived_ns] * len(beacons))
        return vehicle.take_in(Post(RECEIVE, 1, message, b"", arrived_ns)) is None

    assert accepts(10**9, 1, 2)
    assert not accepts(10**9, 1, 2)
    assert not accepts(10**9, 2)
    assert not accepts(10**9, 3)  # other content does not make another frame
    assert accepts(10**9 + 1, 1)
    assert accepts(6 * 10**9, 5)
    assert not accepts(10**9, 4)  # too old to check


def test_in_real_time_no_outcome_of_a_frame_is_accepted_twice(tmp_path: Path) -> None:
    world = RealtimeWorld(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"))
    while world.due_ns <= K * T_NS:
        world.act(world.due_ns)

    def accepts(payload: bytes) -> bool:
        return world.take_in(Post(LINKS, 0, pb.Links(**AT, frames=payload), b"", K * T_NS)) is None

    assert accepts(frames())
    assert not accepts(frames())
    assert accepts(frames(source=[3]))
    assert not accepts(frames(source=[3], destination=[1]))


def test_in_real_time_positions_of_a_cycle_are_accepted_once(tmp_path: Path) -> None:
    channel = RealtimeChannel(scenario_of(tmp_path, f"duration_s: 3\n{FLEET}"))

    def accepts(cycle: int) -> bool:
        return channel.take_in(Post(POSITIONS, 0, pb.Positions(cycle=cycle), b"", 0)) is None

    assert [accepts(cycle) for cycle in (6, 6, 7, 5, 1)] == [True, False, True, True, False]
