"""Both buses write the same log of a scenario, message by message and bit for bit."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import pytest

from tests.conftest import run
from tests.streamed_log import Log
from zenvoy.bus import messages_pb2 as pb

DATA_TOPICS = {
    "/fleet/truth",
    "/fleet/radar",
    "/fleet/estimate",
    "/fleet/command",
    "/v2v/frames",
    "/events",
}

LATE_AND_LOST = """
duration_s: 15
fleet: {size: 8}
control: {model: FM, schedule: [{at_s: 2, model: PBCM}], v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
events: [{vehicle: 3, at_s: 4, duration_s: 2, deceleration_mps2: 3}]
"""

# Big errors and small gaps: FM runs into the vehicle ahead within a quarter of a minute.
COLLIDING = """
duration_s: 60
on_collision: stop
fleet: {size: 4, gap_m: 12}
control: {model: FM, desired_gap_m: 12}
sensors: {error: 0.6}
"""


def both(folder: Path, scenario: str) -> tuple[Log, Log]:
    """Return the logs of a scenario on Zenoh and in process."""
    return (
        run(folder / "zenoh", scenario, "--bus", "zenoh"),
        run(folder / "in-process", scenario, "--bus", "in-process"),
    )


def assert_same(one: Log, other: Log) -> None:
    """Check that messages, their times and their order are equal, not only the hash."""
    assert {message.topic for message in one.messages} <= DATA_TOPICS | {"/clock"}
    for topic in sorted(DATA_TOPICS):
        pairs = zip(one.of(topic), other.of(topic), strict=True)
        differing = [i for i, (a, b) in enumerate(pairs) if a != b]
        assert differing == [], f"{topic}: messages {differing[:5]} differ"
    order = [m.topic for m in one.messages if m.topic != "/clock"]
    assert order == [m.topic for m in other.messages if m.topic != "/clock"]
    assert one.result["fingerprint"] == other.result["fingerprint"]
    assert one.result["end"] == other.result["end"] == "complete"


def outcomes(log: Log) -> Counter[int]:
    """Return how many frames have each outcome."""
    counts: Counter[int] = Counter()
    for message in log.of("/v2v/frames"):
        counts.update(pb.Frames.FromString(message.data).outcome)
    return counts


def modes(log: Log) -> set[int]:
    """Return all modes of vehicles in a run."""
    rows = [pb.FleetEstimate.FromString(message.data) for message in log.of("/fleet/estimate")]
    return {mode for row in rows for mode in row.mode}


def events(log: Log) -> list[pb.Event]:
    """Return the events in the order of the log."""
    return [pb.Event.FromString(message.data) for message in log.of("/events")]


@contextmanager
def busy_cores() -> Iterator[None]:
    """Keep every core busy."""
    spinners = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"])
        for _ in range(os.cpu_count() or 1)
    ]
    try:
        yield
        assert all(spinner.poll() is None for spinner in spinners)
    finally:
        for spinner in spinners:
            spinner.kill()
            spinner.wait()


@pytest.fixture(scope="module")
def late(tmp_path_factory: pytest.TempPathFactory) -> tuple[Log, Log]:
    return both(tmp_path_factory.mktemp("late"), LATE_AND_LOST)


def test_buses_agree_with_late_and_lost_frames(late: tuple[Log, Log]) -> None:
    assert_same(*late)
    zenoh, in_process = late
    assert zenoh.metadata["zenvoy.run"]["bus"] == "zenoh"
    assert in_process.metadata["zenvoy.run"]["bus"] == "in-process"
    counts = outcomes(zenoh)
    assert counts.keys() == {pb.OUTCOME_DELIVERED, pb.OUTCOME_LATE, pb.OUTCOME_LOST}
    assert counts.total() == 150 * 8 * 7
    assert counts[pb.OUTCOME_LATE] > 1000
    assert counts[pb.OUTCOME_LOST] == pytest.approx(0.2 * counts.total(), rel=0.1)
    assert modes(zenoh) >= {pb.MODE_FM, pb.MODE_PBCM}
    assert [event.kind for event in events(zenoh)] == [
        pb.EVENT_MODEL,
        pb.EVENT_BRAKE,
        pb.EVENT_BRAKE_END,
    ]


def test_buses_agree_again_while_every_core_is_busy(late: tuple[Log, Log], tmp_path: Path) -> None:
    with busy_cores():
        again = run(tmp_path / "again", LATE_AND_LOST)
    assert_same(again, late[0])


def test_another_seed_gives_another_log(late: tuple[Log, Log], tmp_path: Path) -> None:
    other = run(tmp_path / "other", LATE_AND_LOST, "--bus", "in-process", "--seed", "2")
    assert other.result["fingerprint"] != late[1].result["fingerprint"]
    assert outcomes(other) != outcomes(late[1])


def test_buses_agree_without_a_wait_for_beacons(tmp_path: Path) -> None:
    scenario = """
    duration_s: 5
    fleet: {size: 6}
    control: {v2v_wait_ms: 0, system_delay_ms: 60}
    channel: {loss: {p: 0.1}}
    """
    zenoh, in_process = both(tmp_path, scenario)
    assert_same(zenoh, in_process)
    first = pb.FleetEstimate.FromString(zenoh.of("/fleet/estimate")[0].data)
    assert list(first.age_ns) == [-1] * 6  # nothing has arrived by then
    command = pb.FleetCommand.FromString(zenoh.of("/fleet/command")[1].data)
    assert set(command.effective_ns) == {160_000_000}


def test_buses_agree_on_the_open_road_out_of_range_of_most(tmp_path: Path) -> None:
    scenario = """
    duration_s: 5
    road: {type: open}
    fleet: {size: 6}
    control: {beacon_age_limit_ms: 150}
    channel: {technology: 5g-mmwave, loss: {p: 0.3}}
    """
    zenoh, in_process = both(tmp_path, scenario)
    assert_same(zenoh, in_process)
    assert outcomes(zenoh)[pb.OUTCOME_LOST] > 0
    assert modes(zenoh) >= {pb.MODE_CONSTANT_SPEED, pb.MODE_PBCM, pb.MODE_FALLBACK_FM}
    assert {event.kind for event in events(zenoh)} == {pb.EVENT_FALLBACK, pb.EVENT_FALLBACK_END}


def test_buses_agree_under_bcm(tmp_path: Path) -> None:
    scenario = """
    duration_s: 5
    fleet: {size: 5}
    control: {model: BCM}
    sensors: {distribution: gaussian, position_std_m: 1}
    channel: {loss: {p: 0.1}}
    """
    zenoh, in_process = both(tmp_path, scenario)
    assert_same(zenoh, in_process)
    assert pb.MODE_BCM in modes(zenoh)


def test_buses_agree_with_payloads_that_exceed_one_message(tmp_path: Path) -> None:
    zenoh, in_process = both(tmp_path, "{duration_s: 3, fleet: {size: 40}}")
    assert_same(zenoh, in_process)
    assert min(len(message.data) for message in zenoh.of("/v2v/frames")) > 60_000


def test_a_collision_stops_the_run_if_the_scenario_says_so(tmp_path: Path) -> None:
    zenoh, in_process = both(tmp_path, COLLIDING)
    assert_same(zenoh, in_process)
    *_, collision, stopped = events(zenoh)
    assert (collision.kind, stopped.kind) == (pb.EVENT_COLLISION, pb.EVENT_STOPPED)
    assert stopped.text == "collision"
    assert collision.time_ns == stopped.time_ns < 60e9
    last = pb.FleetTruth.FromString(zenoh.of("/fleet/truth")[-1].data)
    assert last.time_ns == collision.time_ns
    position = [last.position[-1] + 4 * 12, *last.position]
    follower = collision.vehicle
    assert position[follower - 1] - position[follower] == pytest.approx(5.0, abs=1e-9)


def test_a_collision_does_not_stop_the_run_otherwise(tmp_path: Path) -> None:
    log = run(tmp_path / "on", COLLIDING, "--bus", "in-process", "--set", "on_collision=continue")
    kinds = [event.kind for event in events(log)]
    assert kinds.count(pb.EVENT_COLLISION) > 1
    assert pb.EVENT_STOPPED not in kinds
    assert log.result["cycles"] == "600"
    for message in log.of("/fleet/truth"):
        truth = pb.FleetTruth.FromString(message.data)
        position = [truth.position[-1] + 4 * 12, *truth.position]
        gaps = [ahead - behind for ahead, behind in pairwise(position)]
        assert min(gaps) > 5.0 - 1e-6


def test_buses_agree_on_bursts_of_loss_and_outages(tmp_path: Path) -> None:
    scenario = """
    duration_s: 5
    fleet: {size: 6}
    channel:
      outages: [{from_s: 1, until_s: 3, source: 2-3}, {from_m: 0, to_m: 50}]
      loss:
        gilbert_elliott: {p: 0.1, r: 0.3}
        four_state: {p13: 0.05, p31: 0.4, p32: 0.2, p23: 0.5, p14: 0.05}
    """
    zenoh, in_process = both(tmp_path, scenario)
    assert_same(zenoh, in_process)
    counts = outcomes(zenoh)
    assert counts.keys() == {pb.OUTCOME_DELIVERED, pb.OUTCOME_LOST}
    assert 0.2 < counts[pb.OUTCOME_LOST] / counts.total() < 0.9
