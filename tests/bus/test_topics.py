"""Every stream has the key, writer, reader and log name that docs/architecture.md gives."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any, Final

import pytest

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.log_format import EFFECTIVE, SCENARIO
from zenvoy.bus.log_metadata import REPAIR, RESULT, RUN
from zenvoy.bus.topics import (
    BEACON,
    CLOCK,
    COMMAND,
    ESTIMATE,
    EVENTS,
    FLEET_COMMAND,
    FRAMES,
    LINKS,
    LOGGED,
    POSITIONS,
    RADAR,
    REALTIME,
    RECEIVE,
    SENSE,
    TOPICS,
    TRUTH,
    Topic,
    alive_key,
    processes_key,
    scenario_key,
    time_key,
)

ON_THE_BUS: list[tuple[Topic[Any], str, str, str | None]] = [
    (SENSE, "zenvoy/r1/vehicle/7/sense", "world", "vehicle"),
    (BEACON, "zenvoy/r1/vehicle/7/beacon", "vehicle", "channel"),
    (RECEIVE, "zenvoy/r1/vehicle/7/receive", "channel", "vehicle"),
    (COMMAND, "zenvoy/r1/vehicle/7/command", "vehicle", "world"),
    (POSITIONS, "zenvoy/r1/channel/positions", "world", "channel"),
    (LINKS, "zenvoy/r1/channel/links", "channel", "world"),
    (CLOCK, "zenvoy/r1/clock", "world", None),
    (TRUTH, "zenvoy/r1/truth", "world", "observer"),
]
IN_THE_LOG: list[tuple[Topic[Any], str]] = [
    (CLOCK, "/clock"),
    (TRUTH, "/fleet/truth"),
    (RADAR, "/fleet/radar"),
    (ESTIMATE, "/fleet/estimate"),
    (FLEET_COMMAND, "/fleet/command"),
    (FRAMES, "/v2v/frames"),
    (EVENTS, "/events"),
]


@pytest.mark.parametrize(("topic", "key", "writer", "reader"), ON_THE_BUS)
def test_key_writer_and_reader(
    topic: Topic[Any], key: str, writer: str, reader: str | None
) -> None:
    assert topic.key("r1", 7) == key
    assert (topic.writer, topic.reader) == (writer, reader)
    assert topic.per_vehicle == ("/7/" in key)


def test_there_are_no_other_topics() -> None:
    keyed = {topic for topic in TOPICS if topic.pattern is not None}
    assert keyed == {topic for topic, *_ in ON_THE_BUS}
    assert {topic: topic.logged_as for topic in LOGGED} == dict(IN_THE_LOG)
    assert set(TOPICS) == keyed | set(LOGGED) | {REALTIME}
    assert REALTIME.logged_as == "/realtime"
    assert len({topic.name for topic in TOPICS}) == len(TOPICS)


ROOT: Final = Path(__file__).parents[2]
PACKAGES: Final = tuple(sorted(path.parent.name for path in ROOT.glob("*/py.typed")))
DECLARED_IN: Final = {
    **{topic.log_name: "bus/topics.py" for topic in (*LOGGED, REALTIME)},
    **dict.fromkeys((RUN, RESULT, REPAIR), "bus/log_metadata.py"),
    **dict.fromkeys((SCENARIO, EFFECTIVE), "bus/log_format.py"),
}


CONVOYS = ROOT / "scenarios" / "convoys"
"""It writes folders, not logs; a file there has the name of an attachment."""


def test_names_in_the_log_are_written_once() -> None:
    """Code that reads or writes a log imports its names from `bus`."""
    found: dict[str, list[str]] = {}
    for path in sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py")):
        if path.parent == CONVOYS:
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and node.value in DECLARED_IN:
                found.setdefault(node.value, []).append(path.relative_to(ROOT).as_posix())
    assert found == {name: [place] for name, place in DECLARED_IN.items()}


@pytest.mark.parametrize("topic", [SENSE, BEACON, LINKS])
def test_a_topic_that_is_not_logged_has_no_log_name(topic: Topic[Any]) -> None:
    with pytest.raises(ValueError, match="is not logged"):
        _ = topic.log_name


def test_keys_of_other_entries() -> None:
    assert alive_key("r1", "vehicle-07") == "zenvoy/r1/alive/vehicle-07"
    assert scenario_key("r1") == "zenvoy/r1/scenario"
    assert processes_key("r1") == "zenvoy/r1/processes"
    assert time_key("r1") == "zenvoy/r1/time"


def test_keys_of_all() -> None:
    assert SENSE.key("r1") == "zenvoy/r1/vehicle/*/sense"
    assert LINKS.key("r1") == "zenvoy/r1/channel/links"
    assert alive_key("r1") == "zenvoy/r1/alive/*"


@pytest.mark.parametrize("public", [(), (TRUTH.name,)])
def test_the_truth_is_for_observers_and_only_if_it_is_public(public: tuple[str, ...]) -> None:
    assert TRUTH.is_open(public) == bool(public)
    assert not TRUTH.is_awaited
    assert all(topic.is_open(()) for topic, *_ in ON_THE_BUS if topic is not TRUTH)


@pytest.mark.parametrize("topic", [RADAR, ESTIMATE, FLEET_COMMAND, FRAMES, EVENTS, REALTIME])
def test_what_only_the_log_has_does_not_leave_the_world(topic: Topic[Any]) -> None:
    assert topic.reader is None
    assert topic.writer == "world"
    assert not topic.per_vehicle
    with pytest.raises(ValueError, match="has no key"):
        topic.key("r1")


def test_a_payload_is_decoded_as_the_message_of_its_topic() -> None:
    payload = pb.Sense(cycle=3, vehicle=2, speed=30.0).SerializeToString()
    assert SENSE.decode(payload) == pb.Sense(cycle=3, vehicle=2, speed=30.0)
    with pytest.raises(PayloadError, match="sense: not a Sense"):
        SENSE.decode(payload[:-1])


def test_messages_that_are_waited_for_have_a_cycle() -> None:
    for topic in TOPICS:
        assert "cycle" in topic.message.DESCRIPTOR.fields_by_name
        assert "time_ns" in topic.message.DESCRIPTOR.fields_by_name
        assert ("vehicle" in topic.message.DESCRIPTOR.fields_by_name) >= topic.per_vehicle
