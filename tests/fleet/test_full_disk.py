"""A run whose disk fills up says so, also if that happens while it ends.

The tests stand in for a full disk with a limit on the size of files.
"""

from __future__ import annotations

import resource
import signal
from pathlib import Path

import pytest

from tests.conftest import command
from tests.fleet.long_run import LONG, NAMES, running
from tests.streamed_log import read_log
from zenvoy.bus.log_format import CHUNK_BYTES


def test_a_full_disk_is_reported_in_one_line(tmp_path: Path) -> None:
    """The first chunk always fits, so the log has cycles."""
    (tmp_path / "long.yaml").write_text(LONG)
    limit = (resource.RLIMIT_FSIZE, CHUNK_BYTES + 100_000)
    with command(tmp_path, "run", "long.yaml", "--out", "out", limit=limit) as started:
        started.wait_for_children(NAMES)
        outcome = started.wait()
        assert started.left(0.0) == []
    assert outcome.code == 1
    first, second = outcome.err.splitlines()
    assert first == "world cannot go on: File too large (ulimit -f)"
    assert second.startswith("the log is cut: read up to ")
    assert read_log(tmp_path / "out" / "run.mcap").metadata["zenvoy.run"]["vehicles"] == "3"


@pytest.mark.parametrize(
    ("asked", "number", "code", "first"),
    [
        ("the command", signal.SIGINT, 130, "interrupted; the log up to here is kept"),
        ("channel", signal.SIGKILL, 3, "channel died: killed by SIGKILL"),
    ],
    ids=["interrupted", "after a death"],
)
def test_a_world_that_cannot_finish_its_log_says_why(
    tmp_path: Path, asked: str, number: signal.Signals, code: int, first: str
) -> None:
    with running(tmp_path) as started:
        started.send_to_child("world", signal.SIGSTOP)
        size = (tmp_path / "out" / "run.mcap").stat().st_size
        world = started.wait_for_children(NAMES)["world"]
        resource.prlimit(world, resource.RLIMIT_FSIZE, (size, size))
        if asked == "channel":
            started.send_to_child("channel", number)
        else:
            started.send(number)
        outcome = started.wait()
        assert started.left(0.0) == []
    said, why, cut = outcome.err.splitlines()
    assert (outcome.code, said) == (code, first)
    assert why == "world cannot go on: File too large (ulimit -f)"
    assert cut.startswith("the log is cut: read up to ")
