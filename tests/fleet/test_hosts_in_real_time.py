"""In real time each machine has a clock of its own, which is measured against that of the world."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pytest

from tests.complaints import complaints
from tests.conftest import wait_until, zenvoy
from tests.fleet.hosts import TIMED, host, serving
from tests.streamed_log import read_log
from zenvoy.bus import messages_pb2 as pb

_AHEAD_S: Final = 36_000
_SHIFTED: Final = (
    *("unshare", "--time", "--monotonic", str(_AHEAD_S), "--boottime", str(_AHEAD_S)),
    *("--fork", "--kill-child"),
)


def shifted() -> Sequence[str]:
    """Return a command that runs another one on a clock of hours later; skip where none can be."""
    try:
        subprocess.run((*_SHIFTED, "true"), check=True, capture_output=True, text=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"no time namespaces here: {error}")
    return _SHIFTED


def test_a_machine_whose_clock_is_hours_ahead_drives_on_time(tmp_path: Path) -> None:
    inside = shifted()
    shared = ("--vehicles-per-process", "4")
    with (
        serving(tmp_path, TIMED, *shared) as (served, there),
        host(tmp_path, "alpha", "1-4", *there),
        host(tmp_path, "beta", "5-8", *there, inside=inside) as ahead,
    ):
        outcome = served.wait()
        assert ahead.wait().code == 0
    assert (outcome.code, outcome.err) == (0, "")
    assert complaints(tmp_path / "out") == []
    log = read_log(tmp_path / "out" / "run.mcap")
    rows = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")]
    assert len(rows) == 40
    # Every vehicle sent a command. No clock is in a row without any from another machine.
    whole = [row for row in rows if min(row.clock_error_ns, default=-1) >= 0]
    assert len(whole) > len(rows) / 2
    for row in whole:
        assert 0 < max(row.clock_error_ns) < 500_000_000
        offsets = zip(row.clock_offset_ns, row.clock_error_ns, strict=True)
        ahead_ns = [0] * 4 + [_AHEAD_S * 1_000_000_000] * 4
        true_ns = [-one for one in ahead_ns]  # of the world's clock
        for (offset_ns, error_ns), expected_ns in zip(offsets, true_ns, strict=True):
            assert abs(offset_ns - expected_ns) <= error_ns
    timing = json.loads((tmp_path / "out" / "summary.json").read_text())["real_time"]
    assert 0 < timing["clock_error_ms"]["p50"] < 500
    least, most = timing["clock_drift_ppm"]
    assert least <= 0 <= most  # it is the same oscillator
    assert "clocks of other machines" in outcome.out
    assert timing["commands_late"] + timing["commands_missing"] < 8 * 40 / 2


def test_a_machine_that_knows_the_clock_too_badly_is_refused(tmp_path: Path) -> None:
    (tmp_path / "alpha").mkdir()
    with serving(tmp_path, TIMED, "--set", "max_clock_error_ms=0.001") as (_, there):
        outcome = zenvoy(tmp_path / "alpha", "join", *there, "--vehicles", "1-4", "--host", "alpha")
    assert (outcome.code, outcome.out) == (2, "")
    assert " alpha knows the world's clock to ± " in outcome.err
    assert outcome.err.endswith("allowed: at most max_clock_error_ms (0.001)\n")
    assert outcome.err.count("\n") == 1


def test_a_run_goes_on_without_a_machine_until_it_is_back(tmp_path: Path) -> None:
    shared = ("--vehicles-per-process", "4", "--duration-s", "100000")
    with (
        serving(tmp_path, TIMED, *shared) as (served, there),
        host(tmp_path, "alpha", "1-4", *there),
    ):
        with host(tmp_path, "beta", "5-8", *there) as lost:
            served.wait_for_cycles(tmp_path / "out" / "run.mcap")
            lost.send_to_group(signal.SIGKILL)
            line = "vehicles-05-08 (on beta) has gone; the run goes on\n"
            wait_until(lambda: line in served.out, "it says who has gone")
        with host(tmp_path, "gamma", "5-8", *there):
            wait_until(lambda: "vehicles-05-08" in told_back(tmp_path), "its vehicles are back")
        served.send(signal.SIGINT)
        assert served.wait().code == 130


def told_back(folder: Path) -> list[str]:
    """Return the processes that have come back, by the log so far."""
    log = read_log(folder / "out" / "run.mcap")
    events = [pb.Event.FromString(message.data) for message in log.of("/events")]
    return [event.text for event in events if event.kind == pb.EVENT_PROCESS_BACK]
