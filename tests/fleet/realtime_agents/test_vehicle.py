"""A vehicle's agent decides on the messages that have come, and skips decisions missed by far."""

from __future__ import annotations

from pathlib import Path

from tests.fleet.realtime_agents.one_agent import due, post
from tests.fleet.realtime_agents.runs import MS, QUIET, scenario
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.topics import BEACON, RECEIVE, SENSE
from zenvoy.vehicles.realtime import RealtimeVehicle


def sense(cycle: int, came_ns: int) -> Post:
    message = pb.Sense(cycle=cycle, time_ns=cycle * 100 * MS, vehicle=1, speed=30.0)
    return post(SENSE, 1, came_ns, message)


def receive(source: int, came_ns: int) -> Post:
    beacon = pb.Beacon(vehicle=source).SerializeToString()
    message = pb.Receive(vehicle=1, source=[source], arrived_ns=[10 * MS], beacon=[beacon])
    return post(RECEIVE, 1, came_ns, message)


def sources(command: Envelope) -> list[int]:
    return list(pb.Command.FromString(command.payload).timing.source)


def test_a_message_after_the_decision_counts_in_the_next_one(tmp_path: Path) -> None:
    vehicle = RealtimeVehicle(scenario(tmp_path, QUIET), 1)
    assert due(vehicle) is None
    for heard in (receive(2, 15 * MS), receive(3, 25 * MS), sense(0, 30 * MS), receive(4, 31 * MS)):
        assert vehicle.take_in(heard) is None
    assert vehicle.take_in(sense(0, 32 * MS)) == "stale"
    assert due(vehicle) == 30 * MS
    (beacon,) = vehicle.act(33 * MS)
    assert beacon.topic is BEACON
    assert due(vehicle) == 20 * MS  # past: the sense was late, and the vehicle decides at once
    (command,) = vehicle.act(34 * MS)
    assert sources(command) == [2, 3]
    timing = pb.Command.FromString(command.payload).timing
    assert (timing.sensed_ns, timing.decided_ns) == (30 * MS, 34 * MS)
    assert list(timing.came_ns) == [15 * MS, 25 * MS]
    vehicle.take_in(sense(1, 101 * MS))
    vehicle.act(101 * MS)
    assert due(vehicle) == 120 * MS
    (command,) = vehicle.act(120 * MS)
    assert sources(command) == [4]


def test_a_vehicle_that_is_held_up_for_a_cycle_skips_its_decision(tmp_path: Path) -> None:
    vehicle = RealtimeVehicle(scenario(tmp_path, QUIET), 1)
    vehicle.take_in(sense(0, 0))
    vehicle.act(0)
    assert vehicle.act(20 * MS + 101 * MS) == []
    assert due(vehicle) is None
    vehicle.take_in(sense(1, 122 * MS))
    vehicle.act(122 * MS)
    (command,) = vehicle.act(122 * MS)
    assert pb.Command.FromString(command.payload).cycle == 1
