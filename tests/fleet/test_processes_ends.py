"""Every end of a run has its exit code, its message and its log, and leaves no process."""

from __future__ import annotations

import json
import os
import re
import signal
from pathlib import Path

import psutil
import pytest

from tests.conftest import command, wait_until
from tests.fleet.long_run import LONG, NAMES, assert_stopped, events, running
from tests.let_pass import let_pass
from tests.streamed_log import read_log
from zenvoy.bus import messages_pb2 as pb


@pytest.mark.parametrize("victim", ["vehicle-03", "channel"])
def test_a_killed_process_ends_the_run_by_name(tmp_path: Path, victim: str) -> None:
    with running(tmp_path) as started:
        started.send_to_child(victim, signal.SIGKILL)
        outcome = started.wait()
        assert started.left(0.0) == []
        assert list(Path(started.sockets.name).iterdir()) == []
    assert outcome.code == 3
    assert outcome.err == f"{victim} died: killed by SIGKILL\n"
    log = read_log(tmp_path / "out" / "run.mcap")
    assert_stopped(log)
    assert (pb.EVENT_PROCESS_LOST, victim) in events(log)
    assert (tmp_path / "out" / "summary.json").exists()


def test_a_killed_world_leaves_a_log_that_is_readable_up_to_its_cut(tmp_path: Path) -> None:
    with running(tmp_path) as started:
        started.send_to_child("world", signal.SIGKILL)
        outcome = started.wait()
        assert started.left(0.0) == []
    assert outcome.code == 3
    first, *rest = outcome.err.splitlines()
    assert first == "world died: killed by SIGKILL"
    log = read_log(tmp_path / "out" / "run.mcap")
    assert not log.whole
    last = pb.FleetTruth.FromString(log.of("/fleet/truth")[-1].data)
    read_s = last.time_ns / 1e9
    assert rest == [f"the log is cut: read up to {read_s:g} s of 100000 s"]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["cycles"], summary["end"]) == (last.cycle, None)
    assert log.metadata["zenvoy.run"]["vehicles"] == "3"
    assert [pb.FleetTruth.FromString(m.data).cycle for m in log.of("/fleet/truth")][:2] == [0, 1]


def test_no_folder_of_sockets_is_left_if_the_command_is_killed_after_the_world_is_done(
    tmp_path: Path,
) -> None:
    with running(tmp_path, scenario=LONG.replace("100000", "100")) as started:
        started.send(signal.SIGSTOP)
        sockets = Path(started.sockets.name)
        wait_until(lambda: not any(sockets.iterdir()), "the world has removed its folder")
        started.send(signal.SIGKILL)
        outcome = started.wait()
        assert started.left(10.0) == []
    assert outcome.code == -signal.SIGKILL
    assert read_log(tmp_path / "out" / "run.mcap").result["end"] == "complete"


@pytest.mark.parametrize(
    ("number", "whole_group"),
    [(signal.SIGINT, True), (signal.SIGTERM, False), (signal.SIGHUP, True)],
    ids=["Ctrl-C", "SIGTERM", "hangup"],
)
def test_an_interrupted_run_keeps_its_log(
    tmp_path: Path, number: signal.Signals, whole_group: bool
) -> None:
    with running(tmp_path) as started:
        (started.send_to_group if whole_group else started.send)(number)
        outcome = started.wait()
        assert started.left(0.0) == []
        assert list(Path(started.sockets.name).iterdir()) == []
    assert outcome.code == 130
    assert outcome.err == "interrupted; the log up to here is kept\n"
    assert_stopped(read_log(tmp_path / "out" / "run.mcap"))
    assert (tmp_path / "out" / "summary.json").exists()
    assert all(log.read_text() == "" for log in (tmp_path / "out" / "logs").iterdir())


def test_a_request_to_end_while_processes_start_takes_effect(tmp_path: Path) -> None:
    many = LONG.replace("size: 3", "size: 40")
    (tmp_path / "long.yaml").write_text(many)
    with command(tmp_path, "run", "long.yaml", "--out", "out") as started:
        started.wait_for_children({"world"})
        started.send_to_group(signal.SIGINT)
        outcome = started.wait()
        assert started.left(0.0) == []
    assert outcome.code == 130
    assert outcome.err.splitlines()[0] == "interrupted; the log up to here is kept"
    assert "Traceback" not in outcome.err


def test_a_run_that_is_interrupted_before_its_first_cycle_is_stopped(tmp_path: Path) -> None:
    (tmp_path / "long.yaml").write_text(LONG)
    with command(tmp_path, "run", "long.yaml", "--out", "out") as started:
        # A vehicle that is frozen as soon as it exists keeps the world waiting for its token.
        started.wait_for_children({"vehicle-03"})
        started.send_to_child("vehicle-03", signal.SIGSTOP)
        sockets = Path(started.sockets.name)
        wait_until(lambda: any(sockets.glob("*/world")), "the world listens")
        started.send(signal.SIGTERM)
        outcome = started.wait()
        assert started.left(0.0) == []
    assert outcome.code == 130
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.whole
    assert log.result["end"] == "stopped"


def test_if_the_command_is_killed_its_processes_end_and_the_log_is_complete(tmp_path: Path) -> None:
    with running(tmp_path) as started:
        started.send(signal.SIGKILL)
        assert started.wait().code == -signal.SIGKILL
        assert started.left() == []
        assert list(Path(started.sockets.name).iterdir()) == []
    assert_stopped(read_log(tmp_path / "out" / "run.mcap"))


@pytest.mark.parametrize("victim", ["vehicle-02", "channel", "world"])
def test_a_frozen_process_is_named_after_the_stall_limit(tmp_path: Path, victim: str) -> None:
    with running(tmp_path, "--set", "stall_limit_s=2") as started:
        started.send_to_child(victim, signal.SIGSTOP)
        outcome = started.wait()
        assert started.left(0.0) == []
    assert outcome.code == 3
    assert outcome.err == f"{victim} stalled: a signal or a debugger has stopped it\n"
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.whole
    assert log.result["end"] != "complete"


@pytest.mark.parametrize("victim", ["vehicle-03", "channel", "world"])
def test_a_process_that_is_asked_to_end_by_somebody_else_is_named(
    tmp_path: Path, victim: str
) -> None:
    """It is named long before the stall limit, in place of the processes that wait for it."""
    with running(tmp_path, "--set", "stall_limit_s=1000") as started:
        started.send_to_child(victim, signal.SIGTERM)
        outcome = started.wait()
        assert started.left(0.0) == []
    assert (outcome.code, outcome.err) == (3, f"{victim} died: ended by SIGTERM\n")
    assert_stopped(read_log(tmp_path / "out" / "run.mcap"))


def test_a_fleet_that_was_stopped_as_a_whole_goes_on(tmp_path: Path) -> None:
    """Ctrl-Z and fg do so. No process has kept another waiting."""
    with running(tmp_path, "--set", "stall_limit_s=1") as started:
        log = tmp_path / "out" / "run.mcap"
        started.send_to_group(signal.SIGSTOP)
        let_pass(2.5)  # past the stall limit
        size = log.stat().st_size
        started.send_to_group(signal.SIGCONT)
        wait_until(lambda: log.stat().st_size > 2 * size, "the run goes on")
        started.send(signal.SIGTERM)
        outcome = started.wait()
    assert (outcome.code, outcome.err) == (130, "interrupted; the log up to here is kept\n")


def test_a_study_reports_that_its_process_died(tmp_path: Path) -> None:
    with command(tmp_path, "degradation", "--seeds", "1", "--jobs", "1") as started:
        own = psutil.Process(started.pid)
        wait_until(lambda: bool(own.children()), "a run of the study is under way")
        os.kill(own.children()[0].pid, signal.SIGKILL)
        outcome = started.wait()
    assert outcome.code == 1
    assert re.fullmatch(
        r"the study cannot go on: \S+, seed 1: a process of the study died\n", outcome.err
    ), outcome


def test_processes_are_named_after_their_role_and_run(tmp_path: Path) -> None:
    with running(tmp_path) as started:
        titles = started.children()
        started.send(signal.SIGTERM)
        started.wait()
    run = read_log(tmp_path / "out" / "run.mcap").metadata["zenvoy.run"]["run"]
    assert titles == {name: ["zenvoy", name, run] for name in NAMES}
