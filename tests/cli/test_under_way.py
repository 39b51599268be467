"""A run under way shows its progress, and keeps its log when a signal or a full disk ends it."""

from __future__ import annotations

import json
import os
import pty
import re
import resource
import signal
from pathlib import Path

import pytest

from tests.conftest import LIMIT_S, command, wait_until, zenvoy
from tests.interrupted import assert_keeps_its_log

ENDLESS = "{duration_s: 100000, fleet: {size: 3}}"


@pytest.mark.parametrize("bus", ["zenoh", "in-process"])
def test_progress_is_a_bar_on_a_terminal(tmp_path: Path, bus: str) -> None:
    (tmp_path / "s.yaml").write_text(ENDLESS)
    master, slave = pty.openpty()
    shown = b""

    def bar() -> bool:
        nonlocal shown
        shown += os.read(master, 65_536)
        return b"of 100000 s" in shown and "━".encode() in shown and b"real time" in shown

    try:
        env = {"TERM": "xterm-256color", "PYTHONIOENCODING": "utf-8"}
        with command(tmp_path, "run", "s.yaml", "--out", "o", "--bus", bus, env=env, stdout=slave):
            wait_until(bar, "a bar is shown", LIMIT_S)
    finally:
        os.close(slave)
        os.close(master)


def test_progress_is_plain_lines_without_a_terminal(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(ENDLESS)
    with command(tmp_path, "run", "s.yaml", "--out", "o") as started:
        wait_until(lambda: "\n" in started.out, "a line of progress is printed")
        started.send(signal.SIGTERM)
        outcome = started.wait()
    line = outcome.out.splitlines()[0]
    assert re.fullmatch(r"[\d.]+ of 100000 s, [\d.]+ × real time, \d+ s left", line)
    assert "\x1b" not in outcome.out


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_in_process_keeps_its_log(
    tmp_path: Path, number: signal.Signals
) -> None:
    (tmp_path / "s.yaml").write_text(ENDLESS)
    assert_keeps_its_log(tmp_path, number, "s.yaml", "--bus", "in-process")


def test_a_full_disk_is_reported_in_one_line(tmp_path: Path) -> None:
    """The test stands in for a full disk with a limit on the size of files."""
    (tmp_path / "s.yaml").write_text(ENDLESS)
    options = ["--out", "o", "--bus", "in-process"]
    limit = (resource.RLIMIT_FSIZE, 2_000_000)
    outcome = zenvoy(tmp_path, "run", "s.yaml", *options, limit=limit)
    assert outcome.code == 1
    first, second = outcome.err.splitlines()
    assert first == "the run cannot go on: File too large (ulimit -f)"
    matched = re.fullmatch(r"the log is cut: read up to ([\d.]+) s of 100000 s", second)
    assert matched is not None, second
    summary = json.loads((tmp_path / "o" / "summary.json").read_text())
    assert summary["cycles"] == round(float(matched[1]) * 10) > 10
    assert (summary["end"], summary["fingerprint"]) == (None, None)


def test_a_disk_that_is_full_at_once_leaves_no_cycle(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(ENDLESS)
    options = ["--out", "o", "--bus", "in-process"]
    outcome = zenvoy(tmp_path, "run", "s.yaml", *options, limit=(resource.RLIMIT_FSIZE, 10_000))
    assert outcome.code == 1
    assert outcome.err.splitlines()[1:] == [
        "the log is cut: read up to 0 s of 100000 s",
        "no cycle was logged",
    ]
