"""The world in real time: when commands take effect, who is silent, and which frames are late."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from tests.fleet.realtime_agents.one_agent import due, post
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.frame_table import FRAME_COLUMNS, FRAMES_CODEC
from zenvoy.bus.topics import COMMAND, EVENTS, FRAMES, LINKS, TRUTH
from zenvoy.scenarios import Control, Fleet, Scenario
from zenvoy.world.realtime import RealtimeWorld

MS = 1_000_000
WAIT_MS, DELAY_MS = 20, 60


def new_world(wait_ms: float = WAIT_MS) -> RealtimeWorld:
    control = Control(
        model="FM", v2v_wait_ms=wait_ms, system_delay_ms=DELAY_MS, beacon_age_limit_ms=500.0
    )
    return RealtimeWorld(Scenario(fleet=Fleet(size=2), control=control, clock="realtime"))


def send(
    world: RealtimeWorld, vehicle: int, cycle: int, came_ms: int, acceleration: float = 0.0
) -> None:
    """Hand the world a command that came at a time, ms."""
    time_ns = (100 * cycle + WAIT_MS) * MS
    command = pb.Command(cycle=cycle, time_ns=time_ns, vehicle=vehicle, acceleration=acceleration)
    command.effective_ns = time_ns + DELAY_MS * MS
    assert world.take_in(post(COMMAND, vehicle, came_ms * MS, command)) is None


def act_until(world: RealtimeWorld, until_ms: int) -> list[Envelope]:
    """Let the world do all that is due by a time, ms; return what the last time had."""
    sent: list[Envelope] = []
    while world.due_ns <= until_ms * MS:
        at_ns, sent = world.due_ns, []
        while world.due_ns == at_ns:
            sent += world.act(at_ns)
    return sent


def events_in(sent: Sequence[Envelope]) -> list[tuple[int, int, int]]:
    """Return kind, vehicle and time (ms) of events."""
    found = [pb.Event.FromString(one.payload) for one in sent if one.topic is EVENTS]
    return [(event.kind, event.vehicle, event.time_ns // MS) for event in found]


def test_of_commands_that_come_at_once_the_newest_counts() -> None:
    """A process that was frozen sends all that it missed at once."""
    world = new_world()
    act_until(world, 200)
    for cycle, acceleration in enumerate((-1.0, -2.0, 0.5)):
        send(world, 1, cycle, 210, acceleration)
    sent = act_until(world, 300)
    (truth,) = (pb.FleetTruth.FromString(one.payload) for one in sent if one.topic is TRUTH)
    # -2 m/s² from 210 ms on, and 0.5 m/s² from 280 ms on, where the last one takes effect.
    assert truth.acceleration[0] == pytest.approx(0.7 * -2.0 + 0.2 * 0.5)


def test_commands_that_come_before_a_cycle_begins_make_it_late() -> None:
    world = new_world()
    act_until(world, 0)
    send(world, 1, 0, 99)
    assert world.act(100 * MS) == []
    assert due(world) == 100 * MS
    assert world.act(102 * MS) != []
    assert due(world) == 200 * MS
    assert world.overruns == 1


def test_a_command_before_the_cycle_begins_breaks_the_silence_in_time() -> None:
    world = new_world()
    act_until(world, 400)
    send(world, 1, 4, 490)
    assert events_in(act_until(world, 500)) == [(pb.EVENT_SILENT, 2, 500)]


@pytest.mark.parametrize("cycle", [5, 6])
def test_events_are_in_order_of_time(cycle: int) -> None:
    world = new_world()
    act_until(world, 600)
    send(world, 2, 6, 640)
    send(world, 1, cycle, 650)
    assert events_in(act_until(world, 700)) == [
        (pb.EVENT_SILENT_END, 2, 640),
        (pb.EVENT_SILENT_END, 1, 650),
    ]


@pytest.mark.parametrize(("came_ms", "outcome"), [(290, "DELIVERED"), (310, "LATE")])
def test_a_report_counts_if_it_comes_before_the_cycle_ends(came_ms: int, outcome: str) -> None:
    """It must not matter when the log is written, which is after that."""
    world = new_world(wait_ms=0.0)
    columns = {name: [0] for name in FRAME_COLUMNS} | {
        "source": [2],
        "destination": [1],
        "arrived_ns": [50 * MS],
        "outcome": [pb.OUTCOME_DELIVERED],
    }
    act_until(world, 0)
    links = pb.Links(frames=FRAMES_CODEC.encode(cycle=0, time_ns=0, **columns))
    assert world.take_in(post(LINKS, 0, 60 * MS, links)) is None
    act_until(world, 100)
    send(world, 2, 1, 150)
    report = pb.Command(cycle=1, time_ns=100 * MS, vehicle=1, effective_ns=160 * MS)
    report.timing.source.append(2)
    report.timing.arrived_ns.append(50 * MS)
    report.timing.came_ns.append(50 * MS)
    act_until(world, came_ms)
    assert world.take_in(post(COMMAND, 1, came_ms * MS, report)) is None
    sent = act_until(world, 375)  # cycle 0 ends at 300 ms
    (frames,) = (one.payload for one in sent if one.topic is FRAMES)
    assert pb.Frames.FromString(frames).outcome == [pb.Outcome.Value(f"OUTCOME_{outcome}")]
