"""Damaged logs are reported: no changed byte and no gap goes unnoticed."""

from __future__ import annotations

import struct
import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.reader import make_reader

from tests.conftest import Logged, read_log, zenvoy
from tests.log_surgery import (
    Record,
    chunk_of,
    content_of,
    put_together,
    record_of,
    taken_apart,
    with_content,
    with_data_crc,
    written_anew,
)
from tests.logs import chunk_every, write_log
from tests.mutated_logs.trial import tried
from zenvoy.analysis import LogError, load, read_facts
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.log.repair import RepairError, repair
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import RESULT, RUN, sealed
from zenvoy.bus.log_writer import LogWriter
from zenvoy.cli.analyze import damage_as_log_error

SCENARIO = """
duration_s: 3
seed: 5
fleet: {size: 4}
road: {type: open}
channel: {loss: {p: 0.2}}
control: {model: FM}
"""
TABLES: Final = ("/fleet/truth", "/fleet/radar", "/fleet/estimate", "/fleet/command", "/clock")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a log of 30 cycles, with a chunk for about every fifth of them."""
    file = tmp_path_factory.mktemp("damaged") / "run.mcap"
    return write_log(file, SCENARIO, clock=chunk_every(5))


@pytest.fixture(scope="module")
def content(path: Path) -> bytes:
    return path.read_bytes()


@pytest.fixture(scope="module")
def whole(path: Path) -> Run:
    run = load(path)
    assert run.notes == ()
    assert all(check.holds for check in run.checks), run.checks
    return run


def written(path: Path, content: bytes) -> Path:
    changed = path.with_name("changed.mcap")
    changed.write_bytes(content)
    return changed


def said(log: Path) -> str:
    """Return the notes of a damaged log, or why it is refused, in one line."""
    try:
        return "\n".join(load(log).notes)
    except LogError as error:
        return str(error) if str(error).count("\n") == 0 else ""


def chunks(records: list[Record]) -> list[int]:
    """Return the indices of the chunks among the records."""
    found = [i for i, record in enumerate(records) if record.opcode == Opcode.CHUNK]
    assert len(found) > 4
    return found


def assert_begins(run: Run, whole: Run) -> None:
    """Check that row k is cycle k, as in the whole log."""
    for topic in TABLES:
        table = run[topic]
        np.testing.assert_array_equal(table["cycle"], np.arange(len(table["cycle"])))
        for name, column in table.items():
            np.testing.assert_array_equal(column, whole[topic][name][: len(column)])
    for name, column in run.frames.items():
        np.testing.assert_array_equal(column, whole.frames[name][: len(column)])


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_no_bit_changes_without_a_word(path: Path, content: bytes, data: Any) -> None:
    at = data.draw(st.integers(0, len(content) - 1))
    bit = data.draw(st.integers(0, 7))
    changed = content[:at] + bytes([content[at] ^ 1 << bit]) + content[at + 1 :]
    assert said(written(path, changed)), at


def test_a_chunk_of_another_opcode_is_missed(path: Path, content: bytes, whole: Run) -> None:
    """A reader skips records that it does not know, so the cycles in them are missing."""
    records = taken_apart(content)
    at = chunks(records)[2]
    records[at] = records[at]._replace(opcode=0x55)
    run = load(written(path, put_together(records)))
    assert 0 < run.cycles < whole.cycles
    assert_begins(run, whole)
    text = "\n".join(run.notes)
    assert "the data section does not match its CRC" in text
    assert f"chunks: {len(chunks(taken_apart(content))) - 1} in the file" in text
    assert "the fingerprint does not match the messages" in text
    assert "are missing" in text
    assert f"read up to {run.time_s[-1]:g} s only" in text
    assert run.fingerprint is None
    facts = read_facts(run.log)
    assert facts.counts["/fleet/truth"] < 31
    assert set(facts.faults) <= set(run.notes)


@pytest.mark.parametrize("what", ["dropped", "doubled", "swapped"])
def test_chunks_that_are_not_what_they_were_are_reported_though_every_crc_is_good(
    path: Path, content: bytes, whole: Run, what: str
) -> None:
    records = taken_apart(content)
    first, second = chunks(records)[2:4]
    if what == "dropped":
        del records[first]
    elif what == "doubled":
        records.insert(second, records[first])
    else:
        records[first], records[second] = records[second], records[first]
    run = load(written(path, with_data_crc(put_together(records))))
    assert_begins(run, whole)
    text = "\n".join(run.notes)
    says = {"dropped": "missing", "doubled": "there more than once", "swapped": "not in order"}
    assert says[what] in text
    assert "the fingerprint does not match the messages" in text
    assert "CRC" not in text
    if what == "doubled":
        assert run.cycles == whole.cycles


@pytest.mark.parametrize("name", [RUN, RESULT])
def test_metadata_that_was_changed_is_reported_in_a_cut_log_too(
    path: Path, content: bytes, name: str
) -> None:
    key, value = {RUN: ("seed", b"5"), RESULT: ("end", b"complete")}[name]
    head = struct.pack("<I", len(key)) + key.encode() + struct.pack("<I", len(value))
    assert content.count(head + value) == 1
    changed = content.replace(head + value, head + value[:-1] + b"6")
    for log in (changed, changed[:-1]):
        run = load(written(path, log))
        assert f"metadata {name} does not match its checksum" in run.notes
        assert run.seed == 5
    if name == RUN:
        assert "metadata zenvoy.run has seed 6, effective.json 5" in run.notes


def test_an_attachment_that_was_changed_is_reported(path: Path, content: bytes) -> None:
    changed = content.replace(b"seed: 5\nfleet", b"seed: 6\nfleet")
    run = load(written(path, changed[:-1]))
    assert "attachment 'scenario.yaml' does not match its CRC" in run.notes


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"uncompressed_size": 1 << 63}, "unpacks to 9223372036854775808 bytes"),
        ({"uncompressed_size": 1_000}, "not to 1000 as it says"),
        ({"compression": "zst"}, "compressed with 'zst'; known: zstd, lz4"),
        ({"compression": "lz4"}, "cannot be unpacked"),
        ({"uncompressed_crc": 1}, "does not match its CRC"),
    ],
)
def test_a_chunk_that_lies_is_damage(
    path: Path, content: bytes, change: dict[str, Any], says: str
) -> None:
    records = taken_apart(content)
    at = chunks(records)[2]
    records[at] = record_of(replace(chunk_of(records[at]), **change))
    with pytest.raises(LogError, match=says) as refused:
        load(written(path, put_together(records)))
    assert "\n" not in str(refused.value)
    assert "--salvage" in str(refused.value)


def bomb(records: list[Record], size: int, claimed: int | None) -> bytes:
    """A log with a chunk that unpacks to `size` zeros, and claims `claimed`."""
    compressor = zstandard.ZstdCompressor(write_content_size=claimed is None).compressobj(
        size=size if claimed is None else -1
    )
    block, parts, crc = bytes(1 << 20), [], 0
    for _ in range(size >> 20):
        parts.append(compressor.compress(block))
        crc = zlib.crc32(block, crc)
    parts.append(compressor.flush())
    at = chunks(records)[2]
    changed = replace(
        chunk_of(records[at]),
        data=b"".join(parts),
        uncompressed_size=size if claimed is None else claimed,
        uncompressed_crc=crc,
    )
    records = [*records[:at], record_of(changed), *records[at + 1 :]]
    return with_data_crc(put_together(records))


@pytest.mark.parametrize("claimed", [None, 1 << 20, 60 << 20])
def test_a_chunk_that_unpacks_to_gigabytes_takes_no_gigabytes(
    path: Path, content: bytes, claimed: int | None
) -> None:
    """It may state that size, a smaller one, or none."""
    log = written(path, bomb(taken_apart(content), 1 << 30, claimed))
    assert log.stat().st_size < 1_000_000
    program = """
import resource, sys
from zenvoy.analysis import LogError, load
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    load(sys.argv[1])
except LogError as error:
    print(error)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
    done = subprocess.run(
        [sys.executable, "-c", program, str(log)],
        capture_output=True,
        text=True,
        check=True,
    )
    says, more_kib = done.stdout.splitlines()
    assert "damaged at byte" in says
    assert int(more_kib) < 200 << 10


def test_a_column_of_another_length_is_refused(path: Path, content: bytes) -> None:
    log = read_log(path)
    truth = next(m for m in log.messages if m.topic == "/fleet/truth")
    shorter = truth.data.replace(b"\x1a\x20", b"\x1a\x18", 1)  # position: 32 bytes, then 24
    shorter = shorter[: shorter.index(b"\x1a\x18") + 2 + 24] + shorter[-2 * 34 :]
    anew = written_anew(log, lambda _, m: [m._replace(data=shorter)] if m is truth else [m])
    with pytest.raises(LogError, match=r"/fleet/truth: field position differs in length"):
        load(written(path, anew))
    every = written_anew(
        log, lambda _, m: [m._replace(data=shorter)] if m.topic == truth.topic else [m]
    )
    with pytest.raises(LogError, match=r"position has 3 numbers in a message, not 4"):
        load(written(path, every))


def test_a_reading_from_the_future_is_refused(path: Path, content: bytes) -> None:
    def change(_: int, message: Logged) -> list[Logged]:
        if message.topic != "/fleet/estimate":
            return [message]
        row = pb.FleetEstimate.FromString(message.data)
        row.ahead_measured_ns[1] = row.time_ns + 1
        return [message._replace(data=row.SerializeToString())]

    log = written(path, written_anew(read_log(path), change))
    with pytest.raises(LogError, match="ahead_measured_ns holds a number that cannot"):
        load(log)


def test_only_of_a_damaged_log_is_what_an_analysis_cannot_bear_a_line(
    path: Path, content: bytes, whole: Run
) -> None:
    records = taken_apart(content)
    del records[chunks(records)[-1]]
    damaged = load(written(path, put_together(records)))
    says = "too damaged to be analysed: IndexError: row"
    with pytest.raises(LogError, match=says), damage_as_log_error(damaged):
        raise IndexError("row")
    with pytest.raises(IndexError), damage_as_log_error(whole):
        raise IndexError("row")


def test_the_scenario_of_another_fleet_is_refused(path: Path, content: bytes) -> None:
    log = read_log(path)
    text = log.attachments["effective.json"].replace(b'"size":4', b'"size":5', 1)
    text = text.replace(b'"size": 4', b'"size": 5', 1)
    assert text != log.attachments["effective.json"]
    other = {**log.attachments, "effective.json": text}
    with pytest.raises(LogError, match=r"has 4 numbers in a message, not 5|source has 4"):
        load(written(path, written_anew(replace(log, attachments=other))))


def test_no_messages_at_all_is_a_log_of_nothing(path: Path, content: bytes) -> None:
    run = load(written(path, written_anew(replace(read_log(path), messages=[]))))
    assert run.cycles == 0
    assert "no cycle was logged" in run.notes
    assert "the fingerprint does not match the messages" in run.notes


@pytest.mark.parametrize("value", [None, "many", "-1", ""])
@pytest.mark.parametrize(("name", "key"), [(RUN, "seed"), (RUN, "vehicles"), (RESULT, "cycles")])
def test_metadata_without_a_key_or_with_text_for_a_number_is_corrected_and_reported(
    path: Path, whole: Run, name: str, key: str, value: str | None
) -> None:
    log = read_log(path)
    facts = {k: v for k, v in log.metadata[name].items() if k not in {key, "sha256"}}
    facts |= {} if value is None else {key: value}
    changed = replace(log, metadata={**log.metadata, name: sealed(facts)})
    run = load(written(path, written_anew(changed)))
    says = f"has no {key}" if value is None else f"{key}: {value!r} is not a number"
    assert any(says in note for note in run.notes), run.notes
    assert run.seed == whole.seed
    assert_begins(run, whole)


@pytest.mark.parametrize("name", ["seven.mcap", "7.mcap"])
def test_a_scenario_may_have_any_name_whatever_the_log_is_called(
    path: Path, content: bytes, name: str
) -> None:
    """The stem of the file stands in for a name that is missing; it does not judge one."""
    named = path.with_name(name)
    named.write_bytes(content)
    run = load(named)
    assert run.name == load(path).name
    assert run.notes == ()


def test_a_channel_record_that_is_gone_is_reported(path: Path, content: bytes) -> None:
    records = taken_apart(content)
    at = chunks(records)[0]
    chunk = chunk_of(records[at])
    inner = taken_apart(bytes(8) + content_of(chunk) + bytes(8))
    topics = [record for record in inner if record.opcode == Opcode.CHANNEL]
    inner.remove(next(record for record in topics if b"/fleet/truth" in record.body))
    records[at] = record_of(with_content(chunk, put_together(inner)[8:-8]))
    run = load(written(path, put_together(records)))
    assert any("messages of /fleet/truth" in note or "CRC" in note for note in run.notes)


def test_what_is_compared_is_not_called_equal_where_the_fingerprint_does_not_hold(
    path: Path, content: bytes, tmp_path: Path
) -> None:
    records = taken_apart(content)
    del records[chunks(records)[-1]]
    other = written(path, with_data_crc(put_together(records)))
    outcome = zenvoy(tmp_path, "compare", str(path), str(other), "--out", "c")
    assert outcome.code == 0
    assert "bit for bit" not in outcome.out
    assert "does not match the messages" in outcome.err
    assert "does not match the messages" in (tmp_path / "c" / "compare.html").read_text()


def test_every_command_tells_and_verify_exits_with_1(
    path: Path, content: bytes, tmp_path: Path
) -> None:
    good = zenvoy(tmp_path, "info", "--verify", str(path))
    assert (good.code, good.err) == (0, "")
    assert "the fingerprint matches the messages" in good.out
    records = taken_apart(content)
    at = chunks(records)[3]
    records[at] = records[at]._replace(opcode=0x55)
    log = written(path, put_together(records))
    for arguments, code in (
        (("info",), 0),
        (("info", "--verify"), 1),
        (("export", "--to", "csv", "--out", "e"), 0),
        (("analyze", "--out", "a"), 0),
    ):
        outcome = zenvoy(tmp_path, arguments[0], str(log), *arguments[1:])
        assert outcome.code == code, outcome
        assert "the fingerprint does not match the messages" in outcome.err
        assert "Traceback" not in outcome.err
    report = (tmp_path / "a" / "report.html").read_text()
    assert "The fingerprint does not match the messages." in report


def test_a_log_that_never_ended_has_no_box_for_its_result(
    path: Path, content: bytes, tmp_path: Path
) -> None:
    records = taken_apart(content)
    cut = content[: content.index(records[chunks(records)[3]].body) + 100]
    outcome = zenvoy(tmp_path, "info", str(written(path, cut)))
    assert outcome.code == 0
    assert "result" not in outcome.out
    assert "the log is cut" in outcome.err


# Repairs


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_a_log_cut_anywhere_is_repaired_to_a_whole_one(
    path: Path, content: bytes, whole: Run, data: Any
) -> None:
    at = data.draw(st.integers(len(content) // 4, len(content) - 1))
    cut = written(path, content[:at])
    new = path.with_name("new.mcap")
    new.unlink(missing_ok=True)
    before = load(cut)
    repaired = repair(cut, new)
    assert repaired is not None
    assert cut.read_bytes() == content[:at]
    run = load(new)
    assert all(check.holds for check in run.checks), run.checks
    assert_begins(run, whole)
    for topic in TABLES:
        assert len(run[topic]["cycle"]) == len(before[topic]["cycle"])
    assert any("the log was repaired" in note for note in run.notes)
    assert run.result["end"] == ("complete" if before.result else "cut")
    with new.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert sum(1 for _ in reader.iter_messages()) == sum(repaired.facts.counts.values())


def test_a_damaged_chunk_is_read_past(path: Path, content: bytes, whole: Run) -> None:
    records = taken_apart(content)
    at = chunks(records)[2]
    changed = bytearray(records[at].body)
    changed[len(changed) // 2] ^= 0x10
    records[at] = records[at]._replace(body=bytes(changed))
    log = written(path, put_together(records))
    new = path.with_name("salvaged.mcap")
    with pytest.raises(LogError, match="--salvage"):
        repair(log, new)
    assert not new.exists()
    repaired = repair(log, new, salvage=True)
    assert repaired is not None
    assert any("a chunk does not match its CRC" in fault for fault in repaired.found)
    (missing,) = (fault for fault in repaired.facts.faults if "missing" in fault)
    found = sorted({m.data[1:5] for m in read_log(new).of("/fleet/command")})
    cycles = {struct.unpack("<I", cycle)[0] for cycle in found}
    assert 29 in cycles
    first = min(set(range(1, 30)) - cycles)
    assert str(first) in missing
    run = load(new)
    assert_begins(run, whole)
    assert run.fingerprint == run.result["fingerprint"] != whole.fingerprint


def test_a_chunk_of_another_opcode_is_salvaged_whole(
    path: Path, content: bytes, whole: Run
) -> None:
    records = taken_apart(content)
    at = chunks(records)[2]
    records[at] = records[at]._replace(opcode=0x55)
    new = path.with_name("kind.mcap")
    assert repair(written(path, put_together(records)), new, salvage=True) is not None
    run = load(new)
    assert run.fingerprint == whole.fingerprint
    assert run.cycles == whole.cycles
    assert run.result["end"] == "complete"


def test_a_repair_overwrites_nothing_and_leaves_a_whole_log_alone(
    path: Path, content: bytes, tmp_path: Path
) -> None:
    assert repair(path, tmp_path / "new.mcap") is None
    assert not (tmp_path / "new.mcap").exists()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[:-100])
    for out in (cut, path):
        with pytest.raises(RepairError, match="exists already"):
            repair(cut, out)
    assert cut.read_bytes() == content[:-100]
    outcome = zenvoy(tmp_path, "repair", "cut.mcap")
    assert outcome.code == 0
    assert outcome.out == "cut-repaired.mcap: 3 s of 3 s\n"
    assert zenvoy(tmp_path, "repair", "cut.mcap").code == 2
    assert zenvoy(tmp_path, "repair", "cut.mcap", "--out", "no/such.mcap").code == 1
    assert zenvoy(tmp_path, "info", "--verify", "cut-repaired.mcap").code == 0
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix == ".mcap") == [
        "cut-repaired.mcap",
        "cut.mcap",
    ]


# The writer


def test_the_index_of_chunks_takes_little_memory_and_comes_out_as_it_went_in(
    tmp_path: Path,
) -> None:
    file = tmp_path / "many.mcap"
    chunks_written = 1_000
    with file.open("wb") as stream:
        writer: Any = LogWriter(stream)
        writer.start()
        schema = writer.register_schema("x", "", b"")
        channels = [writer.register_channel(f"/{name}", "", schema) for name in "abcdefg"]
        for number in range(chunks_written):
            for channel in channels:
                writer.add_message(channel, 1 + number, b"x" * (number % 90), 1 + number)
            writer.flush()
        kept = writer._Writer__chunk_indices.nbytes
        writer.finish()
    assert kept < 100 * chunks_written
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert len(summary.chunk_indexes) == chunks_written
        for index in summary.chunk_indexes[::97]:
            assert len(index.message_index_offsets) == len(channels)
        times = [message.log_time for _, _, message in reader.iter_messages()]
    assert times == sorted(times)
    assert len(times) == len(channels) * chunks_written


# Mutants


def test_mutants_end_in_a_line_or_in_notes() -> None:
    """This is a sample of what `python -m tests.mutated_logs` does with ten thousand logs."""
    outcome = tried(60, seed=11, pictures=2)
    assert not outcome.wrong, outcome.wrong[:3]
    assert outcome.drawn == 2
    assert sum(outcome.refused.values()) > 5
    assert sum(outcome.reported.values()) > 20
