"""Without lateness, real time equals lock-step bit for bit. With lateness, the log reports it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.virtual_time import Logged, in_lock_step, in_virtual_time
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.realtime import Post, RealtimeAgent
from zenvoy.bus.topics import BEACON, COMMAND, LINKS, POSITIONS, RECEIVE, SENSE, Topic
from zenvoy.channel.realtime import RealtimeChannel
from zenvoy.scenarios import Scenario, load
from zenvoy.vehicles.realtime import RealtimeVehicle
from zenvoy.world.realtime import RealtimeWorld

DATA = (
    "/fleet/truth",
    "/fleet/radar",
    "/fleet/estimate",
    "/fleet/command",
    "/v2v/frames",
    "/events",
)
LATE_AND_LOST = """
duration_s: 6
fleet: {size: 5}
control: {model: FM, schedule: [{at_s: 2, model: PBCM}], v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {gilbert_elliott: {p: 0.1, r: 0.3}}}
events: [{vehicle: 3, at_s: 4, duration_s: 1, deceleration_mps2: 3}]
"""
SCENARIOS = {
    "late and lost frames": LATE_AND_LOST,
    "deciding on what is at hand": """
duration_s: 4
fleet: {size: 4}
control: {v2v_wait_ms: 0, system_delay_ms: 60}
channel: {loss: {p: 0.1}}
""",
    "out of range of most on the open road": """
duration_s: 4
road: {type: open}
fleet: {size: 5}
control: {beacon_age_limit_ms: 150}
channel: {technology: 5g-mmwave, loss: {p: 0.3}}
""",
    "second copies over a medium with carrier sense": """
duration_s: 3
fleet: {size: 8}
control: {v2v_wait_ms: 30, system_delay_ms: 70}
channel: {medium: {access: csma}, duplicate: 0.2}
""",
    "frames that others pass on": """
duration_s: 3
road: {type: open}
fleet: {size: 8, gap_m: 400}
control: {model: MBCM, v2v_wait_ms: 60}
channel: {relay_hops: 3, loss: {p: 0.1}}
""",
    "many neighbours": """
duration_s: 3
fleet: {size: 7, groups: [{name: deaf, vehicles: '2', beacons: false}]}
control: {model: MBCM, system_delay_ms: 230}
""",
}


def scenario(folder: Path, text: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load(folder / "s.yaml").scenario


def of(topic: str, logged: Logged) -> list[tuple[int, bytes]]:
    return [(time_ns, payload) for name, time_ns, payload in logged if name == topic]


@pytest.mark.parametrize("text", SCENARIOS.values(), ids=SCENARIOS.keys())
def test_without_lateness_real_time_equals_lock_step_bit_for_bit(tmp_path: Path, text: str) -> None:
    settings = scenario(tmp_path, text)
    realtime, stepped = in_virtual_time(settings), in_lock_step(settings)
    for topic in DATA:
        found, expected = of(topic, realtime), of(topic, stepped)
        assert [at for at, _ in found] == [at for at, _ in expected], topic
        assert found == expected, topic
    assert len(of("/realtime", realtime)) == settings.cycles


MS = 1_000_000
QUIET = """
duration_s: 4
fleet: {size: 4}
control: {model: BCM, v2v_wait_ms: 20, system_delay_ms: 80}
"""


def rows(topic: str, kind: Any, logged: Logged) -> list[Any]:
    return [kind.FromString(payload) for _, payload in of(topic, logged)]


def fates(logged: Logged) -> dict[tuple[int, int, int], tuple[bool, int]]:
    """Return whether each frame (source, destination, sequence) is lost, and its latency."""
    return {
        (source, destination, sequence): (outcome == pb.OUTCOME_LOST, latency_ns)
        for frames in rows("/v2v/frames", pb.Frames, logged)
        for source, destination, sequence, outcome, latency_ns in zip(
            frames.source,
            frames.destination,
            frames.sequence,
            frames.outcome,
            frames.latency_ns,
            strict=True,
        )
    }


def events(logged: Logged) -> list[tuple[int, int, int]]:
    found = rows("/events", pb.Event, logged)
    return [(event.kind, event.vehicle, event.time_ns) for event in found]


def test_lateness_does_not_change_which_frames_are_lost(tmp_path: Path) -> None:
    settings = scenario(tmp_path, LATE_AND_LOST)

    def jitter(envelope: Envelope, now_ns: int) -> int:
        """Delay by up to 9 ms. Past 5 ms a beacon is sent after the others of its cycle."""
        digest = hashlib.sha256(envelope.topic.name.encode() + envelope.payload).digest()
        return int.from_bytes(digest[:4], "little") % (9 * MS)

    realtime, stepped = in_virtual_time(settings, jitter), in_lock_step(settings)
    assert fates(realtime) == fates(stepped)
    assert len(fates(realtime)) == 60 * 5 * 4
    lost = [lost for lost, _ in fates(realtime).values()]
    assert 0.1 < np.mean(lost) < 0.4
    reported = {
        (source, destination, arrived_ns)
        for row in rows("/realtime", pb.RealTime, realtime)
        for source, destination, arrived_ns in zip(
            row.source, row.destination, row.arrived_ns, strict=True
        )
    }
    due = {
        (source, destination, 100 * MS * sequence + latency_ns)
        for (source, destination, sequence), (lost, latency_ns) in fates(realtime).items()
        if not lost and sequence < 58  # the run does not wait for the last ones
    }
    assert due <= reported


def test_a_frame_that_comes_after_its_decision_is_late(tmp_path: Path) -> None:
    settings = scenario(tmp_path, QUIET)  # 10.4 ms on the way, 9.6 ms to spare

    def slow(envelope: Envelope, _: int) -> int:
        return 12 * MS if (envelope.topic, envelope.vehicle) == (RECEIVE, 1) else MS

    realtime = in_virtual_time(settings, slow)
    for frames in rows("/v2v/frames", pb.Frames, realtime)[:-1]:
        outcome = dict(zip(frames.destination, frames.outcome, strict=True))
        assert outcome == {1: pb.OUTCOME_LATE, **dict.fromkeys((2, 3, 4), pb.OUTCOME_DELIVERED)}
    for row in rows("/realtime", pb.RealTime, realtime)[1:]:
        late = np.array(row.came_ns) - np.array(row.arrived_ns)
        to_first = np.array(row.destination) == 1
        assert set(late[to_first]) == {12 * MS}
        assert set(late[~to_first]) == {MS}
        assert list(row.sensed_ns) == [row.time_ns + MS] * 4
        assert list(row.decided_ns) == [row.time_ns + 20 * MS] * 4
        assert list(row.commanded_ns) == [row.time_ns + 21 * MS] * 4
        assert row.deadline_ns == row.time_ns + 100 * MS
    ages = [row.age_ns[3] for row in rows("/fleet/estimate", pb.FleetEstimate, realtime)]
    assert set(ages[1:]) == {0}  # the vehicle behind 4 is 1, which is heard in time
    ages = [row.age_ns[0] for row in rows("/fleet/estimate", pb.FleetEstimate, realtime)]
    assert set(ages[1:]) == {100 * MS}


def test_a_late_command_takes_effect_when_it_comes(tmp_path: Path) -> None:
    brake = "events: [{vehicle: 1, at_s: 1, duration_s: 1, deceleration_mps2: 3}]"
    settings = scenario(tmp_path, QUIET + brake)

    def slow(envelope: Envelope, _: int) -> int:
        return 110 * MS if (envelope.topic, envelope.vehicle) == (COMMAND, 2) else 0

    realtime = in_virtual_time(settings, slow)
    for row in rows("/fleet/command", pb.FleetCommand, realtime):
        start_ns = row.time_ns - 20 * MS
        on_time, late = start_ns + 100 * MS, start_ns + 130 * MS
        assert list(row.effective_ns) == [on_time, late, on_time, on_time]
    for timing in rows("/realtime", pb.RealTime, realtime):
        late_ns = np.array(timing.commanded_ns) - timing.deadline_ns
        assert list(late_ns > 0) == [False, True, False, False]
    # Over a period, the command of two cycles ago acts for 30 ms, and then the next one.
    decided = [row.acceleration[1] for row in rows("/fleet/command", pb.FleetCommand, realtime)]
    acted = [row.acceleration[1] for row in rows("/fleet/truth", pb.FleetTruth, realtime)]
    expected = [0.3 * a + 0.7 * b for a, b in pairwise(decided)]
    assert acted[3 : 3 + 30] == pytest.approx(expected[:30], abs=1e-9)
    assert max(map(abs, expected)) > 0.1


def test_a_vehicle_without_commands_keeps_its_acceleration_for_a_while(tmp_path: Path) -> None:
    brake = "events: [{vehicle: 1, at_s: 0.5, duration_s: 1, deceleration_mps2: 3}]"
    settings = scenario(tmp_path, QUIET + brake)

    def mute(envelope: Envelope, now_ns: int) -> int | None:
        silent = 1000 * MS <= now_ns < 2500 * MS
        return None if silent and (envelope.topic, envelope.vehicle) == (COMMAND, 2) else 0

    realtime = in_virtual_time(settings, mute)
    # The command of 0.9 s took effect at 1 s. Beacons are valid for 1 s.
    assert [event for event in events(realtime) if event[0] > 10] == [
        (pb.EVENT_SILENT, 2, 2000 * MS),
        (pb.EVENT_SILENT_END, 2, 2520 * MS),
    ]
    truth = rows("/fleet/truth", pb.FleetTruth, realtime)
    last = rows("/fleet/command", pb.FleetCommand, realtime)[9].acceleration[1]
    acted = [row.acceleration[1] for row in truth]
    assert last < -0.1
    assert acted[11:21] == pytest.approx([last] * 10)
    assert acted[21:26] == [0.0] * 5
    commands = rows("/fleet/command", pb.FleetCommand, realtime)
    assert [np.isnan(row.acceleration[1]) for row in commands] == [
        10 <= cycle < 25 for cycle in range(40)
    ]
    assert {row.effective_ns[1] for row in commands[10:25]} == {-1}
    missing = [row.commanded_ns[1] == -1 for row in rows("/realtime", pb.RealTime, realtime)]
    assert missing == [10 <= cycle < 25 for cycle in range(40)]


def test_a_vehicle_that_was_stopped_goes_on_with_the_newest_sense(tmp_path: Path) -> None:
    settings = scenario(tmp_path, QUIET.replace("BCM", "PBCM"))
    back_ns = 2560 * MS
    inboxes: list[int] = []

    def stopped(envelope: Envelope, now_ns: int) -> int:
        """Hold messages to vehicle 3 from 1 s until it goes on, then deliver them one by one."""
        to_it = envelope.topic.reader == "vehicle" and envelope.vehicle == 3
        if to_it and 1000 * MS <= now_ns < back_ns:
            inboxes.append(now_ns)
            return back_ns - now_ns + len(inboxes) * MS // 10
        return 0

    realtime = in_virtual_time(settings, stopped)
    assert len(inboxes) > 20
    sent = {sequence for source, _, sequence in fates(realtime) if source == 3}
    assert sent == {*range(10), *range(25, 40)}
    commands = rows("/fleet/command", pb.FleetCommand, realtime)
    decided = [not np.isnan(row.acceleration[2]) for row in commands]
    assert decided == [cycle in sent for cycle in range(40)]
    estimate = rows("/fleet/estimate", pb.FleetEstimate, realtime)[25]
    truth = rows("/fleet/truth", pb.FleetTruth, realtime)[25]
    assert estimate.speed[2] == pytest.approx(truth.speed[2], abs=3.0)
    assert estimate.mode[2] == pb.MODE_PBCM


def test_cycles_keep_absolute_deadlines_and_overruns_are_counted(tmp_path: Path) -> None:
    world = RealtimeWorld(scenario(tmp_path, QUIET))
    logged = []
    for cycle, late_ns in enumerate((0, MS, 2 * MS, 350 * MS, 250 * MS, 150 * MS, 50 * MS, 0)):
        if world.due_ns < cycle * 100 * MS:  # late in a cycle, a finished one is logged
            assert world.due_ns == (cycle - 1) * 100 * MS + 75 * MS
            logged += [envelope.topic.logged_as for envelope in world.act(world.due_ns)]
        assert world.due_ns == cycle * 100 * MS
        world.act(world.due_ns + late_ns)
    assert world.overruns == 5
    assert logged[:4] == ["/v2v/frames", "/fleet/estimate", "/fleet/command", "/realtime"]
    assert len(logged) == 5 * 4  # cycles 0 to 4, each after the time of effect of its commands


def test_missing_beacons_delay_no_vehicle_for_long(tmp_path: Path) -> None:
    settings = scenario(tmp_path, QUIET)

    def mute(envelope: Envelope, _: int) -> int | None:
        return None if (envelope.topic, envelope.vehicle) == (BEACON, 4) else 0

    realtime = in_virtual_time(settings, mute)
    assert {source for source, *_ in fates(realtime)} == {1, 2, 3}
    late = [
        came - arrived
        for row in rows("/realtime", pb.RealTime, realtime)
        for came, arrived in zip(row.came_ns, row.arrived_ns, strict=True)
    ]
    assert set(late) == {0}
    outcomes = {o for row in rows("/v2v/frames", pb.Frames, realtime) for o in row.outcome}
    assert outcomes == {pb.OUTCOME_DELIVERED}


def post(topic: Topic[Any], vehicle: int, came_ns: int, message: Any) -> Post:
    return Post(topic, vehicle, message, message.SerializeToString(), came_ns)


def sense(cycle: int, came_ns: int) -> Post:
    message = pb.Sense(cycle=cycle, time_ns=cycle * 100 * MS, vehicle=1, speed=30.0)
    return post(SENSE, 1, came_ns, message)


def receive(source: int, came_ns: int) -> Post:
    beacon = pb.Beacon(vehicle=source).SerializeToString()
    message = pb.Receive(vehicle=1, source=[source], arrived_ns=[10 * MS], beacon=[beacon])
    return post(RECEIVE, 1, came_ns, message)


def due(agent: RealtimeAgent) -> int | None:
    """Return when an agent acts next. A function keeps mypy from narrowing the attribute."""
    return agent.due_ns


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
