"""A repair keeps all readable data, and overwrites nothing."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from tests.conftest import zenvoy
from tests.damaged_logs import TABLES, assert_begins, written
from tests.log_surgery import (
    chunks_among,
    put_together,
    taken_apart,
)
from tests.streamed_log import read_log
from zenvoy.analysis import LogError, load
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.log.repair import RepairError, repair


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_a_log_cut_anywhere_is_repaired_to_a_complete_log(
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


def test_a_damaged_chunk_is_skipped(path: Path, content: bytes, whole: Run) -> None:
    records = taken_apart(content)
    at = chunks_among(records)[2]
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


def test_a_chunk_of_another_opcode_is_recovered_in_full(
    path: Path, content: bytes, whole: Run
) -> None:
    records = taken_apart(content)
    at = chunks_among(records)[2]
    records[at] = records[at]._replace(opcode=0x55)
    new = path.with_name("kind.mcap")
    assert repair(written(path, put_together(records)), new, salvage=True) is not None
    run = load(new)
    assert run.fingerprint == whole.fingerprint
    assert run.cycles == whole.cycles
    assert run.result["end"] == "complete"


def test_a_repair_overwrites_nothing_and_does_not_touch_a_complete_log(
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
