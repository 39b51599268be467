"""A message that makes no sense is refused with a reason, and does not keep the real one out."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any, Final

import pytest

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
from zenvoy.bus.agent import Agent
from zenvoy.bus.mailbox import WINDOW, Mailbox
from zenvoy.bus.topics import BEACON, COMMAND, LINKS, POSITIONS, RECEIVE, SENSE, Topic
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.vehicles.lock_step import LockStepVehicle
from zenvoy.world.lock_step import LockStepWorld

NAN: Final = float("nan")
GOOD: Final[dict[Topic[Any], tuple[int, Any]]] = {
    SENSE: (1, pb.Sense(**AT, vehicle=1, ahead=pb.Link(gap=37.5), speed=30)),
    RECEIVE: (1, receive(beacon_of().SerializeToString())),
    BEACON: (2, beacon_of()),
    POSITIONS: (0, pb.Positions(**AT, position=[3, 2, 1])),
    COMMAND: (1, pb.Command(**COMMANDED, mode=pb.MODE_PBCM)),
    LINKS: (0, pb.Links(**AT, frames=frames())),
}
BAD: Final[list[tuple[str, Topic[Any], Any]]] = [
    ("foreign", SENSE, pb.Sense(**AT, vehicle=2)),
    ("mistimed", SENSE, pb.Sense(cycle=K, time_ns=K * T_NS + 1, vehicle=1)),
    ("absurd", SENSE, pb.Sense(**AT, vehicle=1, ahead=pb.Link(gap=NAN))),
    ("absurd", SENSE, pb.Sense(**AT, vehicle=1, position=float("inf"))),
    ("foreign", RECEIVE, receive(vehicle=3)),
    ("mistimed", RECEIVE, receive(time_ns=-1)),
    ("malformed", RECEIVE, receive(b"", source=[])),
    ("malformed", RECEIVE, receive(b"", arrived_ns=[1, 2])),
    ("malformed", RECEIVE, receive(beacon=[b"", b""])),
    ("absurd", RECEIVE, receive(b"\xff")),
    ("absurd", RECEIVE, receive(beacon_of(3).SerializeToString())),
    ("absurd", RECEIVE, receive(beacon_of(speed=NAN).SerializeToString())),
    ("absurd", RECEIVE, receive(beacon_of(time_ns=(K + 1) * T_NS).SerializeToString())),
    ("foreign", BEACON, beacon_of(3)),
    ("mistimed", BEACON, beacon_of(time_ns=0)),
    ("malformed", BEACON, beacon_of(planned_from_ns=[1, 2])),
    ("malformed", BEACON, beacon_of(planned_from_ns=[], planned_acceleration=[])),
    ("absurd", BEACON, beacon_of(planned_acceleration=[NAN])),
    ("absurd", BEACON, beacon_of(sequence=2**32 - 1)),
    ("mistimed", POSITIONS, pb.Positions(cycle=K, position=[3, 2, 1])),
    ("malformed", POSITIONS, pb.Positions(**AT, position=[3, 2])),
    ("absurd", POSITIONS, pb.Positions(**AT, position=[3, NAN, 1])),
    ("foreign", COMMAND, pb.Command(**{**COMMANDED, "vehicle": 2**32 - 1})),
    ("mistimed", COMMAND, pb.Command(**{**COMMANDED, "time_ns": 1})),
    ("mistimed", COMMAND, pb.Command(**{**COMMANDED, "effective_ns": 0})),
    ("absurd", COMMAND, pb.Command(**{**COMMANDED, "acceleration": NAN})),
    ("mistimed", LINKS, pb.Links(cycle=K, frames=frames())),
    ("malformed", LINKS, pb.Links(**AT)),
    ("mistimed", LINKS, pb.Links(**AT, frames=frames(cycle=K + 1))),
    ("malformed", LINKS, pb.Links(**AT, frames=b"\xff\xff")),
    ("malformed", LINKS, pb.Links(**AT, frames=frames(latency_ns=[]))),
    ("malformed", LINKS, pb.Links(**AT, frames=frames(hops=[1, 1]))),
    ("malformed", LINKS, pb.Links(**AT, frames=frames(busy_ratio=[0.5]))),
    ("absurd", LINKS, pb.Links(**AT, frames=frames(source=[0]))),
    ("absurd", LINKS, pb.Links(**AT, frames=frames(destination=[SIZE + 1]))),
    ("absurd", LINKS, pb.Links(**AT, frames=frames(outcome=[99]))),
]


def reader(topic: Topic[Any], folder: Path) -> Agent:
    scenario = scenario_of(folder, f"duration_s: 3\n{FLEET}")
    roles: dict[str | None, Agent] = {
        "world": LockStepWorld(scenario),
        "channel": LockStepChannel(scenario),
        "vehicle": LockStepVehicle(scenario, 1),
    }
    return roles[topic.reader]


@pytest.mark.parametrize(("reason", "topic", "message"), BAD)
def test_a_message_that_makes_no_sense_does_not_keep_the_real_one_out(
    tmp_path: Path, reason: str, topic: Topic[Any], message: Any
) -> None:
    mailbox = Mailbox(reader(topic, tmp_path).fault_in)
    vehicle, good = GOOD[topic]
    assert mailbox.put(topic, vehicle, message.SerializeToString()) == reason
    assert mailbox.put(topic, vehicle, good.SerializeToString()) is None
    assert mailbox.put(topic, vehicle, good.SerializeToString()) == "duplicate"
    assert mailbox.rejected == Counter([reason, "duplicate"])


def test_an_unknown_mode_is_refused(tmp_path: Path) -> None:
    """Protobuf accepts any number in an enum, even one that no column of the log can hold."""
    payload = pb.Command(**COMMANDED).SerializeToString() + b"\x30" + b"\xff" * 9 + b"\x01"
    assert pb.Command.FromString(payload).mode == -1
    assert Mailbox(reader(COMMAND, tmp_path).fault_in).put(COMMAND, 1, payload) == "absurd"


@pytest.mark.parametrize("mode", [number for number in pb.Mode.values() if number])
def test_every_mode_is_taken_and_no_other(tmp_path: Path, mode: int) -> None:
    """The numbers of the laws have gaps."""
    expected = {mode: None, max(set(pb.Mode.values()) - {pb.MODE_OWN}) + 1: "absurd"}
    for number, reason in expected.items():
        payload = pb.Command(**{**COMMANDED, "mode": number}).SerializeToString()
        assert Mailbox(reader(COMMAND, tmp_path).fault_in).put(COMMAND, 1, payload) == reason


@pytest.mark.parametrize("cycle", [WINDOW, WINDOW + 1, 10**9, 2**32 - 1])
def test_a_message_of_a_cycle_far_ahead_is_not_kept(cycle: int) -> None:
    mailbox = Mailbox()
    message = pb.Positions(cycle=cycle).SerializeToString()
    assert mailbox.put(POSITIONS, 0, message) == "early"
    last = pb.Positions(cycle=WINDOW - 1).SerializeToString()
    assert mailbox.put(POSITIONS, 0, last) is None
