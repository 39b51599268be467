"""A log that grows, is cut or is damaged is shown as far as it goes; what is no log is refused."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from tests.analysis.view.watching import CYCLES, SCENARIO, unpack, watched
from tests.logs import chunk_every, write_log
from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.view.growing_log import GrowingLog
from zenvoy.analysis.view.watched import WatchedRun


@pytest.fixture(scope="module")
def log(folder: Path) -> Path:
    """Return the log of a run, with many small chunks."""
    return write_log(folder / "run.mcap", SCENARIO, clock=chunk_every(7))


def test_a_log_is_read_on_as_it_grows(log: Path, folder: Path) -> None:
    """At whatever byte the file ends for the moment, what is shown is right."""
    content, grown = log.read_bytes(), folder / "grown.mcap"
    final = watched(log)
    expected = unpack(final.cycles(0, CYCLES, 1, ()))
    made = WatchedRun(grown)
    shown = -1
    for size in [*range(0, len(content), 1_777), len(content)]:
        grown.write_bytes(content[:size])
        while made.extend():
            pass
        if not made.begun or made.last < 0:
            continue
        assert made.last >= shown
        shown = made.last
        now = unpack(made.cycles(0, CYCLES, 1, ()))
        assert_array_equal(now["cycle"], np.arange(shown + 1))
        assert_array_equal(now["columns"], expected["columns"][: shown + 1])
    assert made.whole
    assert made.state(0) == final.state(0)
    assert made.overview(0) == final.overview(0)


def test_a_cut_log_is_shown_as_far_as_it_goes(log: Path, folder: Path) -> None:
    cut = folder / "cut.mcap"
    cut.write_bytes(log.read_bytes()[: log.stat().st_size // 2])
    os.utime(cut, (2e9, 2e9))  # just now, however slow the machine is
    made = watched(cut)
    assert 10 < made.last < CYCLES
    state = made.state(0)
    assert (made.whole, state["end"], state["still"]) == (False, None, False)
    os.utime(cut, ns=(0, 0))  # nobody has written to it for long
    made.extend()
    assert made.state(0)["still"]
    cut.write_bytes(log.read_bytes())
    while made.extend():
        pass
    state = made.state(0)
    assert (made.whole, state["end"], state["still"]) == (True, "complete", False)


def test_a_log_that_is_not_there_yet_is_not_still(folder: Path) -> None:
    assert not GrowingLog(folder / "later.mcap").is_still()


def test_a_run_may_pause_for_its_stall_limit(log: Path, folder: Path) -> None:
    """A lock-step run waits so long for a vehicle that somebody debugs."""
    patient = write_log(folder / "patient.mcap", SCENARIO + "stall_limit_s: 1000")
    for path, is_still in ((log, True), (patient, False)):
        cut = folder / "pause.mcap"
        cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        modified_s = cut.stat().st_mtime - 100
        os.utime(cut, (modified_s, modified_s))
        assert watched(cut).state(0)["still"] == is_still


def test_what_is_no_log_is_refused(folder: Path) -> None:
    other = folder / "other.mcap"
    other.write_bytes(b"neither MCAP nor anything else")
    with pytest.raises(LogError, match="not an MCAP file"):
        WatchedRun(other).extend()
    with pytest.raises(LogError, match="No such file"):
        WatchedRun(folder / "missing.mcap").extend()


@pytest.mark.parametrize("chunk", [4, -1])
def test_a_damaged_chunk_is_reported_and_the_rest_is_shown(
    log: Path, folder: Path, chunk: int
) -> None:
    content = bytearray(log.read_bytes())
    made = watched(log)
    place = made._log.chunks[chunk]
    content[place.at + 80] ^= 0xFF
    damaged = folder / "damaged.mcap"
    damaged.write_bytes(content)
    read = watched(damaged)
    assert read.decided() is not None
    (fault,) = read.state(0)["faults"]
    assert f"{damaged}: damaged at byte" in fault
    points = unpack(read.overview(0))
    assert len(points["cycle"]) == CYCLES + 1
    assert 0 < np.isnan(points["totals"][:, 0]).sum() < 30
