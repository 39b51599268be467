"""A fleet in real time runs even without a vehicle, and loses the same frames as in lock-step."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.complaints import complaints
from tests.conftest import Command, command, run, wait_until, zenvoy
from tests.streamed_log import Log, read_log
from zenvoy.bus import messages_pb2 as pb

SHORT = """
duration_s: 3
fleet: {size: 4}
control: {v2v_wait_ms: 50, system_delay_ms: 60}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""
BURSTS = """
duration_s: 4
clock: realtime
fleet: {size: 5}
control: {v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {gilbert_elliott: {p: 0.1, r: 0.3}}}
"""
# Far longer than any test waits.
LONG = """
duration_s: 100000
clock: realtime
fleet: {size: 3}
control: {beacon_age_limit_ms: 500}
"""
NAMES = {"world", "channel", "vehicle-01", "vehicle-02", "vehicle-03"}


@contextmanager
def running(folder: Path, *arguments: str) -> Iterator[Command]:
    """Start a long run in real time, and wait until it has cycles. Its log is out/run.mcap."""
    (folder / "long.yaml").write_text(LONG)
    with command(folder, "run", "long.yaml", "--out", "out", *arguments) as started:
        started.wait_for_children(NAMES)
        started.wait_for_cycles(folder / "out" / "run.mcap")
        yield started


def events(folder: Path) -> list[tuple[int, int, str]]:
    """Return kind, vehicle and text of the events of a run so far."""
    log = read_log(folder / "out" / "run.mcap")
    found = [pb.Event.FromString(message.data) for message in log.of("/events")]
    return [(event.kind, event.vehicle, event.text) for event in found]


def fates(log: Log) -> dict[tuple[int, int, int], tuple[bool, int]]:
    """Return whether each frame (source, destination, sequence) is lost, and its latency."""
    tables = [pb.Frames.FromString(message.data) for message in log.of("/v2v/frames")]
    return {
        (source, destination, sequence): (outcome == pb.OUTCOME_LOST, latency_ns)
        for table in tables
        for source, destination, sequence, outcome, latency_ns in zip(
            table.source,
            table.destination,
            table.sequence,
            table.outcome,
            table.latency_ns,
            strict=True,
        )
    }


@pytest.mark.parametrize("speed", ["1", "2"])
def test_a_run_takes_its_time_on_the_wall_clock(tmp_path: Path, speed: str) -> None:
    log = run(tmp_path / "run", SHORT, "--realtime", "--speed", speed)
    assert log.whole
    assert log.result["end"] == "complete"
    assert log.result["cycles"] == "30"
    assert float(log.result["wall_s"]) >= 3.0 / float(speed)  # no cycle began early
    counts = {channel.topic: len(log.of(channel.topic)) for channel in log.channels.values()}
    per_cycle = ("/fleet/radar", "/fleet/estimate", "/fleet/command", "/v2v/frames", "/realtime")
    assert {counts[topic] for topic in per_cycle} == {30}
    assert counts["/fleet/truth"] == counts["/clock"] == 31
    rows = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")]
    assert [row.time_ns for row in rows] == [cycle * 100_000_000 for cycle in range(30)]
    assert all(row.began_ns >= row.time_ns for row in rows)
    assert any(row.came_ns for row in rows)
    for row in rows:
        lateness = zip(row.came_ns, row.arrived_ns, strict=True)
        assert all(came >= drawn for came, drawn in lateness)  # none came early
    kinds = [pb.Event.FromString(message.data).kind for message in log.of("/events")]
    assert {pb.EVENT_BRAKE, pb.EVENT_BRAKE_END} <= set(kinds)
    reported = json.loads((tmp_path / "run" / "out" / "summary.json").read_text())["real_time"]
    assert reported["speed"] == float(speed)
    assert reported["lateness_ms"]["delivery"]["p50"] >= 0.0
    assert reported["lateness_ms"]["sense"]["max"] >= reported["lateness_ms"]["sense"]["p50"] > 0.0
    assert reported["lateness_ms"]["command"]["p50"] >= -110.0 / float(speed)


def test_the_same_seed_loses_the_same_frames_as_in_lock_step(tmp_path: Path) -> None:
    realtime = fates(run(tmp_path / "realtime", BURSTS, "--speed", "0.5"))
    assert complaints(tmp_path / "realtime" / "out") == []
    stepped = fates(run(tmp_path / "stepped", BURSTS, "--set", "clock=lock-step"))
    assert realtime.items() <= stepped.items()
    assert len(stepped) == 40 * 5 * 4
    assert len(realtime) > len(stepped) / 2  # all, unless the machine held a vehicle up
    assert 0.1 < sum(lost for lost, _ in realtime.values()) / len(realtime) < 0.4
    assert len({latency_ns for _, latency_ns in realtime.values()}) > len(realtime) / 2


def test_a_stopped_vehicle_does_not_end_the_run_and_comes_back(tmp_path: Path) -> None:
    with running(tmp_path) as started:
        started.send_to_child("vehicle-02", signal.SIGSTOP)
        wait_until(lambda: (pb.EVENT_SILENT, 2, "") in events(tmp_path), "vehicle 2 is silent")
        started.send_to_child("vehicle-02", signal.SIGCONT)
        wait_until(lambda: (pb.EVENT_SILENT_END, 2, "") in events(tmp_path), "it is back")
        assert set(started.left(0.0)) == NAMES
        started.send(signal.SIGTERM)
        outcome = started.wait()
        assert started.left() == []
    assert outcome.code == 130
    assert outcome.err == "interrupted; the log up to here is kept\n"
    reported = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert reported["real_time"]["commands_missing"] >= 4  # 0.5 s without any
    assert reported["end"] == "stopped"
    # It is said once that the vehicle is silent, and once that it is back, also if a busy machine
    # holds it up once more.
    spell = [pb.EVENT_SILENT, pb.EVENT_SILENT_END]
    kinds = [kind for kind, vehicle, _ in events(tmp_path) if vehicle == 2 and kind in spell]
    assert kinds == (spell * len(kinds))[: len(kinds)]


def test_a_killed_vehicle_does_not_end_the_run(tmp_path: Path) -> None:
    with running(tmp_path, "--duration-s", "8") as started:
        started.send_to_child("vehicle-03", signal.SIGKILL)
        outcome = started.wait()
        assert started.left() == []
    assert outcome.code == 0
    assert outcome.err == "vehicle-03 died: killed by SIGKILL; the run goes on\n"
    log = read_log(tmp_path / "out" / "run.mcap")
    assert (log.result["end"], log.result["cycles"]) == ("complete", "80")
    found = events(tmp_path)
    assert (pb.EVENT_PROCESS_LOST, 0, "vehicle-03") in found
    assert (pb.EVENT_SILENT, 3, "") in found
    last = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")[-20:]]
    assert {list(row.commanded_ns)[2] for row in last} == {-1}
    assert {1, 2} == {vehicle for row in last for vehicle in row.source}
    assert {1, 2} == {vehicle for row in last for vehicle in row.destination}


def test_a_killed_channel_ends_the_run(tmp_path: Path) -> None:
    with running(tmp_path) as started:
        started.send_to_child("channel", signal.SIGKILL)
        outcome = started.wait()
        assert started.left(0.0) == []
    assert outcome.code == 3
    assert outcome.err == "channel died: killed by SIGKILL\n"
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.whole
    assert log.result["end"] == "stopped"
    # The world notices it by itself, or is asked to end before that.
    ends = {(pb.EVENT_PROCESS_LOST, 0, "channel"), (pb.EVENT_STOPPED, 0, "asked to end")}
    assert ends & set(events(tmp_path))


@pytest.mark.parametrize(
    "end",
    [
        lambda started: started.send_to_group(signal.SIGINT),
        lambda started: started.send(signal.SIGKILL),
    ],
    ids=["Ctrl-C", "kill -9 of the command"],
)
def test_the_log_is_complete_after_every_end(
    tmp_path: Path, end: Callable[[Command], None]
) -> None:
    with running(tmp_path) as started:
        end(started)
        outcome = started.wait()
        assert started.left() == []
        assert list(Path(started.sockets.name).iterdir()) == []
    assert outcome.code in {130, -signal.SIGKILL}
    assert "Traceback" not in outcome.err
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.whole
    assert log.result["end"] == "stopped"
    assert events(tmp_path)[-1] == (pb.EVENT_STOPPED, 0, "asked to end")
    assert complaints(tmp_path / "out") == []


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ("--realtime", "--bus", "in-process"),
            "clock: realtime needs processes; allowed: --engine processes",
        ),
        (("--realtime", "--speed", "11"), "speed: 11.0 is not in [0.1, 10]  (--speed 11.0)"),
        (("--realtime", "--speed", "0"), "speed: 0.0 is not in [0.1, 10]  (--speed 0.0)"),
        (
            ("--speed", "2"),
            "speed: 2 needs clock: realtime; allowed in lock-step: 1  (--speed 2.0)",
        ),
    ],
)
def test_settings_that_cannot_run_are_refused_in_one_line(
    tmp_path: Path, arguments: tuple[str, ...], line: str
) -> None:
    outcome = zenvoy(tmp_path, "run", "quickstart", "--out", "out", *arguments)
    assert (outcome.code, outcome.err) == (2, line + "\n")
    assert not (tmp_path / "out").exists()
