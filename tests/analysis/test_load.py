"""A run is loaded from its log completely, up to a cut, or not at all, with a clear reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf.json_format import MessageToDict
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from tests.log_surgery import add_beside
from tests.logs import write_log
from tests.streamed_log import Log, read_log
from zenvoy.analysis import LogError, load, read_facts
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.load import Run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import LOGGED
from zenvoy.scenarios import effective_json

SCENARIO = """
duration_s: 3
seed: 5
fleet: {size: 4}
road: {type: open}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
control: {v2v_wait_ms: 30, system_delay_ms: 150}
events:
  - {vehicle: 2, at_s: 1, duration_s: 0.5, deceleration_mps2: 2}
"""
FLEET = ("/fleet/truth", "/fleet/radar", "/fleet/estimate", "/fleet/command")
TOPICS = (*FLEET, "/clock", "/v2v/frames")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("load") / "run.mcap", SCENARIO)


@pytest.fixture(scope="module")
def whole(path: Path) -> Run:
    run = load(path)
    assert run.frames["cycle"].size
    return run


def decoded(log: Log, name: str) -> list[Any]:
    """Return the messages of a topic, decoded by protobuf itself."""
    kind = next(topic for topic in LOGGED if topic.logged_as == name)
    return [kind.decode(message.data) for message in log.of(name)]


def test_a_table_equals_what_protobuf_decodes(path: Path, whole: Run) -> None:
    log = read_log(path)
    for topic in (*FLEET, "/clock"):
        rows, table = decoded(log, topic), whole[topic]
        fields = {field.name for field in rows[0].DESCRIPTOR.fields}
        assert set(table) == fields - {"logged"}  # a column for each value that a law logs
        for name, column in table.items():
            expected = np.array([getattr(row, name) for row in rows])
            np.testing.assert_array_equal(column, expected)
            assert column.shape == expected.shape


def test_frames_equal_what_protobuf_decodes(path: Path, whole: Run) -> None:
    rows = decoded(read_log(path), "/v2v/frames")
    for name, column in whole.frames.items():
        if name == "cycle":
            expected = np.concatenate([np.full(len(row.source), row.cycle) for row in rows])
        else:
            expected = np.concatenate([np.array(getattr(row, name)) for row in rows])
        np.testing.assert_array_equal(column, expected)
    assert whole.frame_rows == sum(len(row.source) for row in rows) > 0
    assert whole.frames is whole["/v2v/frames"]


def test_events_and_metadata_equal_those_of_the_log(path: Path, whole: Run) -> None:
    log = read_log(path)
    assert whole.events == decoded(log, "/events")
    assert whole.result == log.result
    assert whole.run == log.metadata["zenvoy.run"]
    assert (whole.name, whole.seed, whole.vehicles, whole.path) == ("run", 5, 4, path)
    assert effective_json(whole.scenario).encode() == log.attachments["effective.json"]
    assert whole.notes == ()


def test_row_k_is_cycle_k_in_every_table(whole: Run) -> None:
    assert whole.cycles == 30
    assert len(whole.time_s) == 31
    assert whole.time_s[-1] == pytest.approx(3.0)
    for topic in FLEET:
        cycle = whole[topic]["cycle"]
        np.testing.assert_array_equal(cycle, np.arange(30 + (topic == "/fleet/truth")))


def test_every_column_has_a_unit(whole: Run) -> None:
    for topic in TOPICS:
        assert set(whole[topic]) <= set(whole.units[topic])
    assert whole.units["/fleet/estimate"]["ahead_gap_std"] == "m"
    assert whole.units["/fleet/estimate"]["ahead_speed"] == "m/s"
    assert whole.units["/fleet/radar"]["relative_speed"] == "m/s"
    assert whole.units["/fleet/command"]["acceleration"] == "m/s²"
    assert whole.units["/v2v/frames"]["latency_ns"] == "ns"
    assert whole.units["/fleet/estimate"]["mode"] == ""


def test_an_unknown_topic_is_a_key_error(whole: Run) -> None:
    with pytest.raises(KeyError):
        whole["/fleet/turth"]


def assert_begins(table: Table, of: Table) -> None:
    for name, column in table.items():
        np.testing.assert_array_equal(column, of[name][: len(column)])


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_a_log_cut_anywhere_is_a_prefix_or_a_refusal(path: Path, whole: Run, data: Any) -> None:
    content = path.read_bytes()
    at = data.draw(st.integers(0, len(content) - 1))
    cut = path.with_name("cut.mcap")
    cut.write_bytes(content[:at])
    scenario = effective_json(whole.scenario).encode()
    if at < content.index(scenario) + len(scenario) + 4:  # the attachment, then its checksum
        with pytest.raises(LogError, match=r"cut\.mcap: .") as refused:
            load(cut)
        assert "\n" not in str(refused.value)
        return
    run = load(cut)
    for topic in TOPICS:
        assert_begins(run[topic], whole[topic])
    assert run.events == whole.events[: len(run.events)]
    assert run.result in ({}, whole.result)
    assert run.notes[0].startswith(f"the log is cut: read up to {max([0, *run.time_s]):g} s of 3 s")
    facts = read_facts(cut)
    assert facts.cut == run.notes[0]
    assert facts.counts["/fleet/radar"] == len(run.radar.get("cycle", ()))


def test_a_log_that_lacks_only_its_index_has_all_rows(path: Path, whole: Run) -> None:
    cut = path.with_name("index.mcap")
    cut.write_bytes(path.read_bytes()[:-1])
    run = load(cut)
    assert run.result == whole.result
    assert run.notes == ("the log is cut: read up to 3 s of 3 s",)
    for topic in TOPICS:
        assert len(run[topic]["cycle"]) == len(whole[topic]["cycle"])
        assert_begins(run[topic], whole[topic])


def test_a_copy_padded_with_zeros_is_read_like_a_cut_log(path: Path, whole: Run) -> None:
    content, padded = path.read_bytes(), path.with_name("zeros.mcap")
    end = content.rindex(b"zenvoy.result", 0, len(content) // 2 * 2) - 13
    padded.write_bytes(content[:end] + bytes(len(content) - end))
    run = load(padded)
    assert run.notes[0].startswith("the log is cut")
    for topic in TOPICS:
        assert_begins(run[topic], whole[topic])


def test_a_chunk_with_a_wrong_byte_is_reported(path: Path) -> None:
    content, wrong = bytearray(path.read_bytes()), path.with_name("wrong.mcap")
    content[content.index(b"zstd") + 200] ^= 0xFF
    wrong.write_bytes(content)
    with pytest.raises(LogError, match=r"wrong\.mcap: damaged at byte \d+: "):
        load(wrong)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.LZ4])
@pytest.mark.parametrize("chunked", [True, False])
def test_a_log_rewritten_by_another_tool_is_read(
    path: Path, whole: Run, compression: CompressionType, chunked: bool
) -> None:
    anew = path.with_name("anew.mcap")
    copy(read_log(path), anew, compression, chunked)
    run = load(anew)
    assert run.notes == ()
    for topic in TOPICS:
        for name, column in run[topic].items():
            np.testing.assert_array_equal(column, whole[topic][name])


def copy(log: Log, path: Path, compression: CompressionType, chunked: bool) -> None:
    with path.open("wb") as file:
        writer = Writer(file, compression=compression, use_chunking=chunked)
        writer.start()
        add_beside(writer, log)
        schema = writer.register_schema("x", "protobuf", b"")
        topics = {
            c.topic: writer.register_channel(c.topic, "", schema) for c in log.channels.values()
        }
        for message in log.messages:
            writer.add_message(topics[message.topic], message.log_time, message.data, 1)
        writer.finish()


def test_an_interrupted_run_is_loaded_with_notes(tmp_path: Path, whole: Run) -> None:
    path = write_log(tmp_path / "i.mcap", SCENARIO, until_cycle=12, lost="vehicle-03")
    run = load(path)
    assert run.notes == (
        "process vehicle-03 was lost at 1.2 s",
        "the run was interrupted at 1.2 s of 3 s",
    )
    assert len(run.truth["cycle"]) == 13
    assert run.cycles == len(run.estimate["cycle"]) < 12
    for topic in (*FLEET, "/v2v/frames"):  # wall time is in /clock
        assert_begins(run[topic], whole[topic])


def test_a_run_that_ended_before_its_first_cycle_is_loaded(tmp_path: Path) -> None:
    run = load(write_log(tmp_path / "e.mcap", SCENARIO, until_cycle=0))
    assert run.notes == ("the run was interrupted at 0 s of 3 s", "no cycle was logged")
    assert run.cycles == 0
    assert run.frame_rows == 0
    assert all(len(column) == 0 for column in run.frames.values())


def test_a_collision_that_stops_a_run_is_noted(tmp_path: Path) -> None:
    crash = """
duration_s: 20
on_collision: stop
fleet: {size: 4, gap_m: 8}
control: {model: FM, desired_gap_m: 8}
events: [{vehicle: 1, at_s: 0.5, duration_s: 5, deceleration_mps2: 9}]
"""
    run = load(write_log(tmp_path / "c.mcap", crash))
    last = run.events[-1]
    assert MessageToDict(last)["kind"] == "EVENT_STOPPED"
    assert run.notes == (f"the run was stopped at {run.time_s[-1]:g} s of 20 s: collision",)
    assert any(event.kind == pb.EVENT_COLLISION for event in run.events)


def test_notes_on_the_scenario_keep_their_lines(tmp_path: Path) -> None:
    two = "duration_s: 3\nfleet: {size: 3}\ncontrol: {schedule: [{at_s: 9, model: BCM}]}\n"
    two += "events: [{vehicle: 1, at_s: 9, duration_s: 1, deceleration_mps2: 2}]\n"
    notes = load(write_log(tmp_path / "run.mcap", two)).notes
    assert len(notes) == 2
    assert all(note.startswith("the scenario: ") for note in notes)
