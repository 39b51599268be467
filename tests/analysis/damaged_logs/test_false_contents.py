"""Logs with false contents and valid checksums are refused, or corrected and reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.damaged_logs import assert_begins, written
from tests.log_surgery import (
    rewritten,
)
from tests.streamed_log import Logged, read_log
from zenvoy.analysis import LogError, load
from zenvoy.analysis.log.load import Run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import RESULT, RUN, sealed


def test_a_column_of_another_length_is_refused(path: Path, content: bytes) -> None:
    log = read_log(path)
    truth = next(m for m in log.messages if m.topic == "/fleet/truth")
    shorter = truth.data.replace(b"\x1a\x20", b"\x1a\x18", 1)  # position: 32 bytes, then 24
    shorter = shorter[: shorter.index(b"\x1a\x18") + 2 + 24] + shorter[-2 * 34 :]
    anew = rewritten(log, lambda _, m: [m._replace(data=shorter)] if m is truth else [m])
    with pytest.raises(LogError, match=r"/fleet/truth: field position differs in length"):
        load(written(path, anew))
    every = rewritten(
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

    log = written(path, rewritten(read_log(path), change))
    with pytest.raises(LogError, match="ahead_measured_ns holds a number that cannot"):
        load(log)


def test_the_scenario_of_another_fleet_is_refused(path: Path, content: bytes) -> None:
    log = read_log(path)
    text = log.attachments["effective.json"].replace(b'"size":4', b'"size":5', 1)
    text = text.replace(b'"size": 4', b'"size": 5', 1)
    assert text != log.attachments["effective.json"]
    other = {**log.attachments, "effective.json": text}
    with pytest.raises(LogError, match=r"has 4 numbers in a message, not 5|source has 4"):
        load(written(path, rewritten(replace(log, attachments=other))))


def test_a_log_without_messages_has_empty_tables(path: Path, content: bytes) -> None:
    run = load(written(path, rewritten(replace(read_log(path), messages=[]))))
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
    run = load(written(path, rewritten(changed)))
    says = f"has no {key}" if value is None else f"{key}: {value!r} is not a number"
    assert any(says in note for note in run.notes), run.notes
    assert run.seed == whole.seed
    assert_begins(run, whole)


@pytest.mark.parametrize("name", ["seven.mcap", "7.mcap"])
def test_a_scenario_may_have_any_name_whatever_the_log_is_called(
    path: Path, content: bytes, name: str
) -> None:
    """The stem of the file replaces a missing name, and does not check an existing one."""
    named = path.with_name(name)
    named.write_bytes(content)
    run = load(named)
    assert run.name == load(path).name
    assert run.notes == ()
