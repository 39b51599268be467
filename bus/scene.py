"""Draws the fleet as messages that 3D panels of Foxglove and Lichtblick show.

A ring lies around the origin of the frame `road`, and vehicles drive against the clock. An open
road is the x axis. A vehicle's position is that of its front.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any, Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_format import EPOCH_NS
from zenvoy.bus.scene_schema import SCENE, TRANSFORMS, scene_class
from zenvoy.bus.summary import GapsOf, Summary
from zenvoy.bus.topics import FRAMES, TRUTH, vehicle_name

SCENE_TOPIC: Final = "/scene"
TRANSFORMS_TOPIC: Final = "/tf"
SUMMARY_TOPIC: Final = "/fleet/summary"
SCENE_TOPICS: Final = {
    SCENE_TOPIC: SCENE,
    TRANSFORMS_TOPIC: TRANSFORMS,
    SUMMARY_TOPIC: pb.FleetSummary.DESCRIPTOR.full_name,
}
"""Topics that go with a scene, and their messages. The fingerprint leaves them out."""

ROAD: Final = "road"
"""The frame in which everything is drawn."""
FLEET: Final = "fleet"
"""A frame that goes with the vehicles: in the middle of a ring, or of an open road's fleet."""

_WIDTH_M: Final = 1.8
_HEIGHT_M: Final = 1.5
_LANE_M: Final = 4.0
_BESIDE_M: Final = 8.0  # from a vehicle to its number, on its right
_MARGIN_M: Final = 50.0  # of an open road beyond its vehicles
_CORNERS: Final = 180  # of a ring
_NS: Final = 1_000_000_000
_GREY: Final = (0.45, 0.45, 0.45)
_SPEEDS: Final = (  # from standstill on; the palette viridis, which colour-blind readers can tell
    (0.267, 0.005, 0.329),
    (0.229, 0.322, 0.545),
    (0.128, 0.567, 0.551),
    (0.369, 0.789, 0.383),
    (0.993, 0.906, 0.144),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """What a scene needs to know of its scenario. At `fast_mps` a vehicle has the last colour."""

    vehicles: int
    ring_length_m: float | None
    gaps_of: GapsOf
    vehicle_length_m: float
    fast_mps: float


class Scene:
    """The scene of a run. One set of messages is filled again in each cycle, to save time."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._summary = Summary(stage.gaps_of)
        self._scene = scene_class(SCENE)()
        self._frames = scene_class(TRANSFORMS)()
        self._road = self._scene.entities.add(id=ROAD, frame_id=ROAD)
        _add_line(self._road, _LANE_M, _GREY)
        if stage.ring_length_m is not None:
            radius = stage.ring_length_m / (2 * pi)
            angles = (2 * pi * corner / _CORNERS for corner in range(_CORNERS))
            corners = ((radius * cos(angle), radius * sin(angle)) for angle in angles)
            _set_points(self._road.lines[0], corners)
            self._road.lines[0].type = 1  # LINE_LOOP
        names = [vehicle_name(number + 1, stage.vehicles) for number in range(stage.vehicles)]
        self._vehicles = [self._add_vehicle(name) for name in names]
        for name in (FLEET, *names):
            self._frames.transforms.add(parent_frame_id=ROAD, child_frame_id=name).rotation.w = 1

    def take(self, topic: str, payload: bytes) -> dict[str, bytes]:
        """Take a message of the log; return the messages by topic that follow the truth of a cycle.

        Raises DecodeError or ValueError for messages that are none, or of another fleet.
        """
        if topic == FRAMES.log_name:
            self._summary.take(payload)
        return self._draw(payload) if topic == TRUTH.log_name else {}

    def _draw(self, truth: bytes) -> dict[str, bytes]:
        state = pb.FleetTruth.FromString(truth)
        stage = self._stage
        if not len(state.position) == len(state.speed) == stage.vehicles:
            raise ValueError(f"{len(state.position)} positions of {stage.vehicles} vehicles")
        stamp = divmod(EPOCH_NS + state.time_ns, _NS)
        fleet, *frames = self._frames.transforms
        if stage.ring_length_m is None:
            self._stretch_road(state.position)
            fleet.translation.x = (max(state.position) + min(state.position)) / 2
        for each in (*self._scene.entities, *self._frames.transforms):
            each.timestamp.seconds, each.timestamp.nanos = stamp
        rows = zip(self._vehicles, frames, state.position, state.speed, strict=True)
        for entity, frame, position, speed in rows:
            x, y, heading = self._place(position - stage.vehicle_length_m / 2)
            cube, text = entity.cubes[0], entity.texts[0]
            for at in (cube.pose.position, frame.translation):
                at.x, at.y = x, y
            beside = text.pose.position
            beside.x, beside.y = x + _BESIDE_M * sin(heading), y - _BESIDE_M * cos(heading)
            for turn in (cube.pose.orientation, frame.rotation):
                turn.z, turn.w = sin(heading / 2), cos(heading / 2)
            colour = _colour(speed / stage.fast_mps)
            _paint(cube.color, colour)
            _paint(text.color, colour)  # from afar, the number is all that one sees
        return {
            SCENE_TOPIC: self._scene.SerializeToString(),
            TRANSFORMS_TOPIC: self._frames.SerializeToString(),
            SUMMARY_TOPIC: self._summary.of(state).SerializeToString(),
        }

    def _place(self, along_m: float) -> tuple[float, float, float]:
        """Return x and y (m) and heading (rad) at a place along the road."""
        if self._stage.ring_length_m is None:
            return along_m, 0.0, 0.0
        radius = self._stage.ring_length_m / (2 * pi)
        angle = along_m / radius % (2 * pi)
        return radius * cos(angle), radius * sin(angle), angle + pi / 2

    def _stretch_road(self, positions: Iterable[float]) -> None:
        *_, last = ordered = sorted(positions)
        ends = ((ordered[0] - _MARGIN_M, 0.0), (last + _MARGIN_M, 0.0))
        _set_points(self._road.lines[0], ends)

    def _add_vehicle(self, name: str) -> Any:
        """Add an entity with a cube, and its number beside it."""
        entity = self._scene.entities.add(id=name, frame_id=ROAD)
        cube = entity.cubes.add()
        cube.size.x, cube.size.y, cube.size.z = self._stage.vehicle_length_m, _WIDTH_M, _HEIGHT_M
        cube.pose.position.z = _HEIGHT_M / 2
        cube.color.a = 1
        text = entity.texts.add(
            billboard=True, font_size=12, scale_invariant=True, text=name.rpartition("-")[2]
        )
        text.pose.orientation.w = 1
        text.color.a = 1
        return entity


def _add_line(entity: Any, thickness_m: float, colour: tuple[float, float, float]) -> None:
    line = entity.lines.add(thickness=thickness_m)
    line.pose.orientation.w = 1
    line.pose.position.z = -0.1  # below the wheels
    _paint(line.color, colour)
    line.color.a = 1


def _set_points(line: Any, points: Iterable[tuple[float, float]]) -> None:
    del line.points[:]
    for x, y in points:
        line.points.add(x=x, y=y)


def _paint(color: Any, colour: tuple[float, ...]) -> None:
    color.r, color.g, color.b = colour


def _colour(share: float) -> tuple[float, ...]:
    """Return the colour of a speed, given as a share of the one with the last colour."""
    last = len(_SPEEDS) - 1
    at = min(max(share, 0.0), 1.0) * last
    lower = min(int(at), last - 1)
    pairs = zip(_SPEEDS[lower], _SPEEDS[lower + 1], strict=True)
    return tuple(low + (high - low) * (at - lower) for low, high in pairs)
