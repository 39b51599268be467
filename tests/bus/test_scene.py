"""The scene of a log shows each vehicle where it is, by the schemas of Foxglove's SDK."""

from __future__ import annotations

from functools import partial
from math import cos, hypot, pi, sin
from pathlib import Path
from typing import Any

import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from hypothesis import given
from hypothesis import strategies as st

from tests.logs import write_log
from tests.scene_schema import schemas
from zenvoy.analysis.log.load import load
from zenvoy.analysis.log.records import Pass
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_format import EPOCH_NS
from zenvoy.bus.scene import (
    FLEET,
    ROAD,
    SCENE_TOPIC,
    SCENE_TOPICS,
    SUMMARY_TOPIC,
    TRANSFORMS_TOPIC,
    Scene,
    Stage,
)
from zenvoy.bus.scene_schema import SCENE, TRANSFORMS, scene_class, scene_schema
from zenvoy.bus.topics import FRAMES, TRUTH
from zenvoy.links.distance import gaps

RING_M = 300.0


def stage(ring_length_m: float | None) -> Stage:
    return Stage(
        vehicles=3,
        ring_length_m=ring_length_m,
        gaps_of=partial(gaps, ring_length_m=ring_length_m),
        vehicle_length_m=5,
        fast_mps=30,
    )


def truth(position: list[float], speed: list[float]) -> bytes:
    return pb.FleetTruth(
        cycle=7, time_ns=1_500_000_000, position=position, speed=speed
    ).SerializeToString()


def drawn(of: Stage, position: list[float], speed: list[float]) -> tuple[Any, Any]:
    messages = Scene(of).take(TRUTH.log_name, truth(position, speed))
    return (
        scene_class(SCENE).FromString(messages[SCENE_TOPIC]),
        scene_class(TRANSFORMS).FromString(messages[TRANSFORMS_TOPIC]),
    )


def test_the_schemas_are_those_of_the_sdk() -> None:
    assert FileDescriptorSet.FromString(scene_schema()) == FileDescriptorSet.FromString(schemas())


@given(st.lists(st.floats(-1e5, 1e5), min_size=3, max_size=3))
def test_on_a_ring_each_vehicle_is_on_the_circle_and_looks_along_it(position: list[float]) -> None:
    scene, transforms = drawn(stage(RING_M), position, [30.0, 30.0, 0.0])
    road, *vehicles = scene.entities
    radius = RING_M / (2 * pi)
    assert [entity.id for entity in vehicles] == ["vehicle-01", "vehicle-02", "vehicle-03"]
    assert all(hypot(at.x, at.y) == pytest.approx(radius) for at in road.lines[0].points)
    for entity, along in zip(vehicles, position, strict=True):
        (cube,) = entity.cubes
        angle = (along - 2.5) / radius
        at, turn = cube.pose.position, cube.pose.orientation
        assert (at.x, at.y) == pytest.approx((radius * cos(angle), radius * sin(angle)), abs=1e-6)
        heading = 2 * turn.w * turn.z  # the sine of twice the half angle
        assert heading == pytest.approx(cos(angle), abs=1e-6)
        (number,) = entity.texts
        beside = number.pose.position  # outside the ring
        assert (beside.x, beside.y) == pytest.approx(
            ((radius + 8) * cos(angle), (radius + 8) * sin(angle)), abs=1e-6
        )
        assert number.color == cube.color
        assert (cube.size.x, entity.frame_id, number.text) == (5, ROAD, entity.id[-2:])
    assert [t.child_frame_id for t in transforms.transforms] == [FLEET, *(v.id for v in vehicles)]
    assert transforms.transforms[0].translation.x == 0  # the middle of the ring


def test_an_open_road_goes_from_behind_the_last_vehicle_to_ahead_of_the_first() -> None:
    scene, transforms = drawn(stage(None), [1100.0, 1050.0, 1000.0], [0.0, 15.0, 40.0])
    road, *vehicles = scene.entities
    assert [(at.x, at.y) for at in road.lines[0].points] == [(950, 0), (1150, 0)]
    assert [v.cubes[0].pose.position.x for v in vehicles] == [1097.5, 1047.5, 997.5]
    numbers = [v.texts[0].pose.position for v in vehicles]
    assert [(at.x, at.y) for at in numbers] == [(1097.5, -8), (1047.5, -8), (997.5, -8)]
    assert transforms.transforms[0].translation.x == 1050
    colours = [tuple(round(x, 3) for x in (c.r, c.g, c.b)) for c in cubes_of(vehicles)]
    assert colours == [(0.267, 0.005, 0.329), (0.128, 0.567, 0.551), (0.993, 0.906, 0.144)]
    stamps = {(e.timestamp.seconds, e.timestamp.nanos) for e in scene.entities}
    assert stamps == {(EPOCH_NS // 10**9 + 1, 500_000_000)}


def cubes_of(vehicles: list[Any]) -> list[Any]:
    return [vehicle.cubes[0].color for vehicle in vehicles]


def test_a_summary_counts_gaps_of_the_ring_and_the_newest_frames() -> None:
    scene = Scene(stage(RING_M))
    outcomes = [pb.OUTCOME_DELIVERED] * 3 + [pb.OUTCOME_LOST, pb.OUTCOME_CORRUPTED, 250]
    assert scene.take(FRAMES.log_name, pb.Frames(outcome=outcomes).SerializeToString()) == {}
    messages = scene.take(TRUTH.log_name, truth([200.0, 110.0, 0.0], [10.0, 20.0, 30.0]))
    found = pb.FleetSummary.FromString(messages[SUMMARY_TOPIC])
    assert (found.cycle, found.time_ns, found.mean_speed) == (7, 1_500_000_000, 20)
    assert found.smallest_gap == 90  # of 100, 90 and 110
    assert found.gap_rms == pytest.approx((200 / 3) ** 0.5)
    assert found.speed_rms == pytest.approx((200 / 3) ** 0.5)
    assert (found.delivered, found.late, found.lost, found.collided) == (3, 0, 2, 0)


def test_a_truth_of_another_fleet_is_refused() -> None:
    with pytest.raises(ValueError, match="2 positions of 3 vehicles"):
        drawn(stage(None), [1.0, 0.0], [0.0, 0.0])


@pytest.mark.parametrize("road", ["ring", "open"])
def test_a_scene_is_logged_on_request_and_leaves_the_fingerprint_as_it_is(
    tmp_path: Path, road: str
) -> None:
    run = f"duration_s: 2, fleet: {{size: 4}}, road: {{type: {road}}}"
    plain = load(write_log(tmp_path / "plain.mcap", f"{{{run}}}"))
    path = write_log(tmp_path / "scene.mcap", f"{{{run}, log: {{scene: true}}}}")
    shown = load(path)
    assert (shown.fingerprint, shown.notes) == (plain.fingerprint, plain.notes)
    with Pass(path, check=True) as log:
        found = [(message.topic, message.log_time_ns) for message in log.messages(SCENE_TOPICS)]
        declared = {
            channel.topic: (channel.message_encoding, log.schemas[channel.schema_id])
            for channel in log.channels.values()
        }
    assert log.faults == []
    for topic, name in SCENE_TOPICS.items():
        times = [time_ns for at, time_ns in found if at == topic]
        assert times == [EPOCH_NS + cycle * 100_000_000 for cycle in range(21)]
        encoding, schema = declared[topic]
        assert (encoding, schema.name, schema.encoding) == ("protobuf", name, "protobuf")
    with Pass(tmp_path / "plain.mcap") as log:
        assert list(log.messages(SCENE_TOPICS)) == []
    assert not SCENE_TOPICS.keys() & set(log.topics.values())
