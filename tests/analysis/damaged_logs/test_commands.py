"""Every command that reads a log reports its damage in readable lines."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.damaged_logs import written
from tests.log_surgery import (
    chunks_among,
    put_together,
    taken_apart,
    with_data_crc,
)
from tests.mutated_logs.trial import tried
from zenvoy.analysis import LogError, load
from zenvoy.analysis.log.load import Run
from zenvoy.cli.analyze import damage_as_log_error


def test_errors_of_an_analysis_are_one_line_only_for_damaged_logs(
    path: Path, content: bytes, whole: Run
) -> None:
    records = taken_apart(content)
    del records[chunks_among(records)[-1]]
    damaged = load(written(path, put_together(records)))
    says = "too damaged to be analysed: IndexError: row"
    with pytest.raises(LogError, match=says), damage_as_log_error(damaged):
        raise IndexError("row")
    with pytest.raises(IndexError), damage_as_log_error(whole):
        raise IndexError("row")


def test_runs_with_a_wrong_fingerprint_are_not_called_equal(
    path: Path, content: bytes, tmp_path: Path
) -> None:
    records = taken_apart(content)
    del records[chunks_among(records)[-1]]
    other = written(path, with_data_crc(put_together(records)))
    outcome = zenvoy(tmp_path, "compare", str(path), str(other), "--out", "c")
    assert outcome.code == 0
    assert "bit for bit" not in outcome.out
    assert "does not match the messages" in outcome.err
    assert "does not match the messages" in (tmp_path / "c" / "compare.html").read_text()


def test_every_command_reports_damage_and_verify_exits_with_1(
    path: Path, content: bytes, tmp_path: Path
) -> None:
    good = zenvoy(tmp_path, "info", "--verify", str(path))
    assert (good.code, good.err) == (0, "")
    assert "the fingerprint matches the messages" in good.out
    records = taken_apart(content)
    at = chunks_among(records)[3]
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
    cut = content[: content.index(records[chunks_among(records)[3]].body) + 100]
    outcome = zenvoy(tmp_path, "info", str(written(path, cut)))
    assert outcome.code == 0
    assert "result" not in outcome.out
    assert "the log is cut" in outcome.err


def test_mutants_end_in_one_line_or_in_notes() -> None:
    """This is a sample of `python -m tests.mutated_logs`, which tries ten thousand logs."""
    outcome = tried(60, seed=11, pictures=2)
    assert not outcome.wrong, outcome.wrong[:3]
    assert outcome.drawn == 2
    assert sum(outcome.refused.values()) > 5
    assert sum(outcome.reported.values()) > 20
