"""A reader reports every changed byte, and every chunk that is lost, doubled or out of order."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode

from tests.damaged_logs import assert_begins, notes_or_refusal, written
from tests.log_surgery import (
    chunk_of,
    chunks_among,
    content_of,
    put_together,
    record_of,
    taken_apart,
    with_content,
    with_data_crc,
)
from zenvoy.analysis import load, read_facts
from zenvoy.analysis.log.load import Run
from zenvoy.bus.log_metadata import RESULT, RUN


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_every_changed_bit_is_reported(path: Path, content: bytes, data: Any) -> None:
    at = data.draw(st.integers(0, len(content) - 1))
    bit = data.draw(st.integers(0, 7))
    changed = content[:at] + bytes([content[at] ^ 1 << bit]) + content[at + 1 :]
    assert notes_or_refusal(written(path, changed)), at


def test_a_chunk_of_another_opcode_is_reported_as_missing(
    path: Path, content: bytes, whole: Run
) -> None:
    """A reader skips records that it does not know, so the cycles in them are missing."""
    records = taken_apart(content)
    at = chunks_among(records)[2]
    records[at] = records[at]._replace(opcode=0x55)
    run = load(written(path, put_together(records)))
    assert 0 < run.cycles < whole.cycles
    assert_begins(run, whole)
    text = "\n".join(run.notes)
    assert "the data section does not match its CRC" in text
    assert f"chunks: {len(chunks_among(taken_apart(content))) - 1} in the file" in text
    assert "the fingerprint does not match the messages" in text
    assert "are missing" in text
    assert f"read up to {run.time_s[-1]:g} s only" in text
    assert run.fingerprint is None
    facts = read_facts(run.log)
    assert facts.counts["/fleet/truth"] < 31
    assert set(facts.faults) <= set(run.notes)


@pytest.mark.parametrize("what", ["dropped", "doubled", "swapped"])
def test_changed_chunks_are_reported_even_with_valid_crcs(
    path: Path, content: bytes, whole: Run, what: str
) -> None:
    records = taken_apart(content)
    first, second = chunks_among(records)[2:4]
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
def test_changed_metadata_is_reported_even_in_a_cut_log(
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


def test_a_changed_attachment_is_reported(path: Path, content: bytes) -> None:
    changed = content.replace(b"seed: 5\nfleet", b"seed: 6\nfleet")
    run = load(written(path, changed[:-1]))
    assert "attachment 'scenario.yaml' does not match its CRC" in run.notes


def test_a_missing_channel_record_is_reported(path: Path, content: bytes) -> None:
    records = taken_apart(content)
    at = chunks_among(records)[0]
    chunk = chunk_of(records[at])
    inner = taken_apart(bytes(8) + content_of(chunk) + bytes(8))
    topics = [record for record in inner if record.opcode == Opcode.CHANNEL]
    inner.remove(next(record for record in topics if b"/fleet/truth" in record.body))
    records[at] = record_of(with_content(chunk, put_together(inner)[8:-8]))
    run = load(written(path, put_together(records)))
    assert any("messages of /fleet/truth" in note or "CRC" in note for note in run.notes)
