"""The log on disk keeps up with a run that is under way."""

from __future__ import annotations

from pathlib import Path

from tests.streamed_log import read_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import EVENTS
from zenvoy.fleet.labels import labels_of
from zenvoy.scenarios import load
from zenvoy.world.recorder import Recorder


def test_messages_logged_before_a_long_wait_are_on_disk(tmp_path: Path) -> None:
    """No cycle begins for long at a tenth of real time, or while the run waits for a vehicle."""
    now_ns = 0

    def on_disk() -> int:
        return len(read_log(tmp_path / "run.mcap").of("/events"))

    labels = labels_of(load("quickstart"), "zenvoy", 1)
    with Recorder(tmp_path / "run.mcap", labels, lambda: now_ns) as recorder:
        recorder.log(EVENTS, 0, pb.Event(text="told").SerializeToString())
        now_ns = 300_000_000
        recorder.flush_if_due()
        assert on_disk() == 0
        now_ns = 400_000_000
        recorder.flush_if_due()
        assert on_disk() == 1
