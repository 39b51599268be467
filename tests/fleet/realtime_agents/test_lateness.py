"""With lateness, the log reports it, and no other frames are lost than in lock-step."""

from __future__ import annotations

import hashlib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.fleet.realtime_agents.logged import fates, rows
from tests.fleet.realtime_agents.runs import LATE_AND_LOST, MS, QUIET, scenario
from tests.fleet.realtime_agents.stops import check_goes_on_with_the_newest_senses, held_from
from tests.virtual_time import Logged, in_lock_step, in_virtual_time
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.topics import BEACON, COMMAND, RECEIVE


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
    held: list[int] = []
    realtime = in_virtual_time(settings, held_from([3], held))
    assert len(held) > 20
    check_goes_on_with_the_newest_senses(realtime)


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
