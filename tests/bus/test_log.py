"""The log can be read with only `mcap` and the descriptors inside the file.

All tests read the log of one run of 40 processes, which takes seconds, so they share a module.
"""

from __future__ import annotations

import hashlib
import json
import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader

from tests.conftest import run
from tests.streamed_log import Log
from zenvoy.bus.topics import LOGGED

# Commands take effect in the second period after their cycle's start, brakes inside a period.
SCENARIO = """
description: for the tests of the log
duration_s: 6
seed: 42
fleet: {size: 40, speed_mps: 25}
control: {model: BCM, v2v_wait_ms: 11, system_delay_ms: 150}
sensors: {error: 0}
channel: {loss: {p: 0.1}}
events:
  - {vehicle: 5, at_s: 1.03, duration_s: 1.5, deceleration_mps2: 3}
  - {vehicle: 1, at_s: 2, duration_s: 1, deceleration_mps2: 2.5}
"""
VEHICLES, CYCLES, PERIOD_NS, RING_M = 40, 60, 100_000_000, 1500.0
FLEET = {"/fleet/truth": 61, "/fleet/radar": 60, "/fleet/estimate": 60, "/fleet/command": 60}
COUNTS = {**FLEET, "/v2v/frames": 60, "/clock": 61}
# Filled only by MBCM, by carrier sense, and by relaying.
ELSEWHERE = {"neighbours", "busy_ratio", "hops", "logged"}
FIELDS = {
    "/fleet/truth": {"position", "speed", "acceleration"},
    "/fleet/radar": {"gap", "relative_speed"},
    "/fleet/estimate": {"mode", "age_ns", "ahead_gap", "behind_gap", "ahead_predicted_gap"},
    "/fleet/command": {"acceleration", "effective_ns"},
    "/v2v/frames": {
        "source",
        "destination",
        "sequence",
        "sent_ns",
        "arrived_ns",
        "latency_ns",
        "distance",
        "outcome",
    },
    "/events": {"kind", "vehicle", "text"},
    "/clock": {"cycle", "wall_ns", "real_time_factor", "overruns"},
}


@dataclass(frozen=True, slots=True)
class Recorded:
    """A finished run: its folder, its log, and the messages decoded, by topic."""

    folder: Path
    log: Log
    rows: dict[str, list[Any]]

    @property
    def path(self) -> Path:
        """Return the path of the log."""
        return self.folder / "out" / "run.mcap"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    folder = tmp_path_factory.mktemp("log") / "run"
    log = run(folder, SCENARIO)
    return Recorded(folder, log, decode(log))


def decode(log: Log) -> dict[str, list[Any]]:
    """Return messages by topic, of types made from the descriptors in the file."""
    types: dict[str, Any] = {}
    for channel in log.channels.values():
        schema = log.schemas[channel.schema_id]
        assert (schema.encoding, channel.message_encoding) == ("protobuf", "protobuf")
        pool = descriptor_pool.DescriptorPool()
        for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
            pool.Add(file)
        types[channel.topic] = message_factory.GetMessageClass(
            pool.FindMessageTypeByName(schema.name)
        )
    return {topic: [types[topic].FromString(m.data) for m in log.of(topic)] for topic in types}


def test_every_topic_has_a_message_per_cycle(recorded: Recorded) -> None:
    counts = {topic: len(rows) for topic, rows in recorded.rows.items()}
    assert counts == {**COUNTS, "/events": counts["/events"]}


def test_events_have_their_time_vehicle_and_size(recorded: Recorded) -> None:
    events = [(e.cycle, e.time_ns, e.vehicle, e.text) for e in recorded.rows["/events"]]
    assert [event for event in events if event[1] > 10 * PERIOD_NS] == [
        (10, 1_030_000_000, 5, "3 m/s²"),
        (20, 2_000_000_000, 1, "2.5 m/s²"),
        (25, 2_530_000_000, 5, ""),
        (30, 3_000_000_000, 1, ""),
    ]
    # A vehicle that has not heard its follower yet falls back, with an event.
    early = {event[2] for event in events if event[1] <= 10 * PERIOD_NS}
    first = recorded.rows["/v2v/frames"][0]
    heard = zip(first.source, first.destination, first.arrived_ns, strict=True)
    deaf = {to for of, to, at_ns in heard if of == to % VEHICLES + 1 and at_ns < 0}
    assert early == deaf != set()


def test_fields_have_the_names_that_plots_show(recorded: Recorded) -> None:
    for topic, names in FIELDS.items():
        assert names <= set(recorded.rows[topic][0].DESCRIPTOR.fields_by_name), topic


def test_columns_have_an_entry_per_vehicle_or_frame(recorded: Recorded) -> None:
    for topic, size in [*((topic, {VEHICLES}) for topic in FLEET), ("/v2v/frames", None)]:
        for row in recorded.rows[topic]:
            fields = [f.name for f in row.DESCRIPTOR.fields if f.is_repeated]
            columns = [name for name in fields if name not in ELSEWHERE]
            lengths = {len(getattr(row, name)) for name in columns}
            assert lengths == (size or {VEHICLES * (VEHICLES - 1)}), (topic, row.cycle)


def test_log_times_are_the_epoch_and_simulation_time(recorded: Recorded) -> None:
    epoch_ns = int(recorded.log.metadata["zenvoy.run"]["epoch_ns"])
    assert epoch_ns > 0
    for topic, rows in recorded.rows.items():
        for row, message in zip(rows, recorded.log.of(topic), strict=True):
            assert message.log_time == message.publish_time == epoch_ns + row.time_ns, topic
    starts_ns = [cycle * PERIOD_NS for cycle in range(CYCLES + 1)]
    assert [row.time_ns for row in recorded.rows["/fleet/truth"]] == starts_ns
    assert [row.cycle for row in recorded.rows["/fleet/truth"]] == list(range(CYCLES + 1))
    assert [row.time_ns for row in recorded.rows["/v2v/frames"]] == starts_ns[:-1]
    decided_ns = [start_ns + 11_000_000 for start_ns in starts_ns[:-1]]
    assert [row.time_ns for row in recorded.rows["/fleet/command"]] == decided_ns


def test_the_file_has_the_designed_layout(recorded: Recorded) -> None:
    assert recorded.log.header.profile == ""
    with recorded.path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert len(summary.chunk_indexes) > 1
    assert {index.compression for index in summary.chunk_indexes} == {"zstd"}
    assert len({schema.name for schema in summary.schemas.values()}) == len(summary.schemas)
    assert len(summary.schemas) == len(summary.channels) == len(FIELDS)
    assert len({schema.data for schema in summary.schemas.values()}) == 1  # the whole of it


def test_metadata_and_attachments_describe_the_run(recorded: Recorded) -> None:
    log, out = recorded.log, recorded.folder / "out"
    described = log.metadata["zenvoy.run"]
    assert (
        described.items()
        >= {
            "scenario": "s",
            "seed": "42",
            "cycles": "60",
            "period_ns": "100000000",
            "vehicles": "40",
            "bus": "zenoh",
        }.items()
    )
    assert {"version.zenvoy", "version.eclipse-zenoh", "version.mcap", "python"} <= set(described)
    assert log.attachments["scenario.yaml"] == (recorded.folder / "s.yaml").read_bytes()
    assert log.attachments["effective.json"] == (out / "effective.json").read_bytes()
    assert json.loads(log.attachments["effective.json"])["control"]["gains"]["k_d"] == 0.1
    result = log.metadata["zenvoy.result"]
    assert (result["end"], result["cycles"], result["simulated_s"]) == ("complete", "60", "6")
    summary = json.loads((out / "summary.json").read_text())
    assert summary["fingerprint"] == result["fingerprint"]


def test_the_fingerprint_covers_the_messages_in_the_file(recorded: Recorded) -> None:
    names = {topic.logged_as: topic.name for topic in LOGGED}
    epoch_ns = int(recorded.log.metadata["zenvoy.run"]["epoch_ns"])
    digest = hashlib.sha256()
    for message in recorded.log.messages:
        if message.topic == "/clock":
            continue
        time_ns, size = message.log_time - epoch_ns, len(message.data)
        digest.update(names[message.topic].encode() + b"\0")
        digest.update(time_ns.to_bytes(8, "little") + size.to_bytes(8, "little") + message.data)
    assert recorded.log.result["fingerprint"] == digest.hexdigest()


@pytest.mark.parametrize("part", [0.4, 0.8])
def test_a_truncated_file_is_readable_up_to_the_cut(
    recorded: Recorded, tmp_path: Path, part: float
) -> None:
    cut = tmp_path / "cut.mcap"
    whole = recorded.path.read_bytes()
    cut.write_bytes(whole[: int(part * len(whole))])
    found: list[tuple[str, int, bytes]] = []
    with cut.open("rb") as file:
        messages = NonSeekingReader(file).iter_messages(log_time_order=False)
        with suppress(McapError, struct.error):
            for _, channel, message in messages:
                found.append((channel.topic, message.log_time, message.data))
    expected = [(m.topic, m.log_time, m.data) for m in recorded.log.messages]
    assert 0 < len(found) < len(expected)
    assert found == expected[: len(found)]
    assert found[-1][1] > recorded.log.messages[0].log_time + 10 * PERIOD_NS


def test_the_gaps_that_radars_read_add_up_to_the_ring(recorded: Recorded) -> None:
    """Sensors have no error here; for the truth this holds by definition."""
    truths = recorded.rows["/fleet/truth"]
    for radar, truth in zip(recorded.rows["/fleet/radar"], truths, strict=False):
        assert sum(radar.gap) == pytest.approx(RING_M, abs=1e-9)
        assert sum(radar.relative_speed) == pytest.approx(0.0, abs=1e-9)
        ahead = [truth.position[-1] + RING_M, *truth.position[:-1]]
        gaps = [front - own for front, own in zip(ahead, truth.position, strict=True)]
        assert list(radar.gap) == pytest.approx(gaps, abs=1e-9)


def test_speeds_change_by_the_mean_acceleration(recorded: Recorded) -> None:
    truths = recorded.rows["/fleet/truth"]
    for before, after in pairwise(truths):
        change = [v - u for u, v in zip(before.speed, after.speed, strict=True)]
        assert change == pytest.approx([a * 0.1 for a in after.acceleration], abs=1e-12)


def test_commands_act_from_their_effective_time(recorded: Recorded) -> None:
    """The truth of each cycle follows from the one before and the commands then in effect."""
    commands, truths = recorded.rows["/fleet/command"], recorded.rows["/fleet/truth"]
    assert all(set(c.effective_ns) == {c.time_ns + 150_000_000} for c in commands)
    for vehicle in range(VEHICLES):
        decided = [(c.effective_ns[vehicle], c.acceleration[vehicle]) for c in commands]
        assert len({a for _, a in decided}) > 20  # commands differ
        for before, after in pairwise(truths):
            x, v = before.position[vehicle], before.speed[vehicle]
            for dt_s, a in pieces(before.time_ns, after.time_ns, vehicle + 1, decided):
                x, v = x + v * dt_s + a * dt_s**2 / 2, v + a * dt_s
            assert after.speed[vehicle] == pytest.approx(v, abs=1e-9), (vehicle, after.cycle)
            assert after.position[vehicle] == pytest.approx(x, abs=1e-9), (vehicle, after.cycle)


def pieces(
    from_ns: int, until_ns: int, vehicle: int, decided: list[tuple[int, float]]
) -> Iterator[tuple[float, float]]:
    """Yield durations, s, and accelerations, m/s², that the scenario and the commands ask for."""
    brakes = {5: (1_030_000_000, 2_530_000_000, 3.0), 1: (2_000_000_000, 3_000_000_000, 2.5)}
    brake_from_ns, brake_until_ns, rate = brakes.get(vehicle, (0, 0, 0.0))
    edges = {brake_from_ns, brake_until_ns, *(at_ns for at_ns, _ in decided)}
    inner = sorted(edge for edge in edges if from_ns < edge < until_ns)
    bounds = [from_ns, *inner, until_ns]
    for start_ns, end_ns in pairwise(bounds):
        in_effect = [a for at_ns, a in decided if at_ns <= start_ns]
        a = max(-3.0, min(3.0, in_effect[-1])) if in_effect else 0.0
        yield (end_ns - start_ns) * 1e-9, -rate if brake_from_ns <= start_ns < brake_until_ns else a
