"""A helper interrupts a run of the `zenvoy` command, and checks the files that it leaves."""

from __future__ import annotations

import signal
from pathlib import Path

from tests.conftest import command
from tests.streamed_log import read_log


def assert_keeps_its_log(folder: Path, number: signal.Signals, *arguments: str) -> None:
    """Run with `arguments` in `folder`, interrupt the run in a cycle, and check its log."""
    with command(folder, "run", *arguments, "--out", "o") as started:
        started.wait_for_cycles(folder / "o" / "run.mcap")
        started.send(number)
        outcome = started.wait()
    assert (outcome.code, outcome.err) == (130, "interrupted; the log up to here is kept\n")
    log = read_log(folder / "o" / "run.mcap")
    assert log.whole
    assert log.result["end"] == "stopped"
    assert (folder / "o" / "summary.json").exists()
