"""Vehicles whose processes are killed, frozen or slowed, with the same log on every bus."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
import psutil
import pytest
from numpy.typing import NDArray

from tests.conftest import command, run, wait_until, zenvoy
from tests.faults import scenario_with
from tests.logs import write_log
from tests.streamed_log import read_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.log.load import Run
from zenvoy.bus import messages_pb2 as pb

Floats = NDArray[np.float64]

ENGINES: Final = {
    "alone": (),
    "shared": ("--vehicles-per-process", "3"),
    "in one": ("--engine", "in-process"),
}
MANY: Final = """
duration_s: 8
on_vehicle_loss: restart
fleet: {size: 7}
control: {model: PBCM, v2v_wait_ms: 50, system_delay_ms: 70}
channel: {loss: {p: 0.1}}
events: [{vehicle: 1, at_s: 3, duration_s: 1, deceleration_mps2: 2}]
faults:
  - {type: process-killed, vehicles: 3, at_s: 2.03, duration_s: 1.5}
  - {type: process-killed, vehicles: 3, at_s: 5, duration_s: 1}
  - {type: process-frozen, vehicles: 5-6, at_s: 2.5, duration_s: 2}
  - {type: process-slowed, vehicles: 2, at_s: 3, duration_s: 1, delay_ms: 330}
  - {type: transmitter-silent, vehicles: 4, at_s: 4, duration_s: 1}
"""
LOSS: Final = """
duration_s: 6
fleet: {size: 5}
sensors: {error: 0}
control: {model: BCM}
"""
KILLED: Final = "faults: [{type: process-killed, vehicles: 3, at_s: 2.05, deceleration_mps2: 2}]\n"


@pytest.mark.parametrize("wait_ms", [50, 0])
def test_processes_log_the_same_as_one_process(tmp_path: Path, wait_ms: int) -> None:
    text = MANY.replace("v2v_wait_ms: 50", f"v2v_wait_ms: {wait_ms}")
    logs = {name: run(tmp_path / name, text, *options) for name, options in ENGINES.items()}
    assert len({log.result["fingerprint"] for log in logs.values()}) == 1


def test_a_killed_process_dies_and_another_one_replaces_it(tmp_path: Path) -> None:
    faults = "[{type: process-killed, vehicles: 3, at_s: 30, duration_s: 2}]"
    text = f"{LOSS.replace('duration_s: 6', 'duration_s: 120')}on_vehicle_loss: restart\n"
    (tmp_path / "s.yaml").write_text(f"{text}faults: {faults}\n")
    with command(tmp_path, "run", "s.yaml", "--out", "out") as running:
        first = running.wait_for_children({"vehicle-03"})["vehicle-03"]

        def replaced() -> bool:
            running.children()
            return running.pid_of("vehicle-03") not in {None, first}

        wait_until(replaced, "another process of vehicle 3")
        assert not psutil.pid_exists(first)
        running.wait_for_children({"vehicle-03"})
        assert running.wait().code == 0
        assert running.left() == []
    logs = sorted(path.name for path in (tmp_path / "out" / "logs").glob("vehicle-03*"))
    assert logs == ["vehicle-03-2.log", "vehicle-03.log"]


@pytest.mark.parametrize(("policy", "slower_mps"), [("coast", 0.0), ("brake", 2.0 * 3.9)])
def test_a_lost_vehicle_coasts_or_brakes(tmp_path: Path, policy: str, slower_mps: float) -> None:
    """From the cycle at 2.1 s on, to 6 s."""
    text = f"{LOSS}on_vehicle_loss: {policy}\n{KILLED}"
    found = load(write_log(tmp_path / "run.mcap", text))
    speed = found.truth["speed"][:, 2]
    np.testing.assert_allclose(speed[21] - speed[60], slower_mps, atol=1e-9)
    commands = found.command["acceleration"][:, 2]
    assert np.isfinite(commands[:21]).all()
    assert np.isnan(commands[21:]).all()
    sources = found.frames["source"]
    assert found.frames["cycle"][sources == 3].max() == 20
    assert all(section.title for section in chapters(found))


@pytest.mark.parametrize("options", ENGINES.values(), ids=ENGINES)
def test_a_run_ends_with_its_vehicle_unless_told_otherwise(
    tmp_path: Path, options: tuple[str, ...]
) -> None:
    (tmp_path / "s.yaml").write_text(LOSS + KILLED)
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--out", "out", *options)
    assert outcome.code == 3
    assert "vehicle-03 died: killed by a fault of the scenario at 2.1 s" in outcome.err
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.whole
    last = pb.Event.FromString(log.of("/events")[-1].data)
    assert (last.kind, last.text, last.time_ns) == (
        pb.EVENT_STOPPED,
        "vehicle-03 killed",
        2_100_000_000,
    )


def in_process(tmp_path: Path, fault: str, more: str = "") -> Run:
    return load(write_log(tmp_path / "run.mcap", f"{LOSS}{more}faults:\n  - {fault}\n"))


def test_a_restarted_vehicle_has_an_empty_filter(tmp_path: Path) -> None:
    fault = "{type: process-killed, vehicles: 3, at_s: 2, duration_s: 2}"
    text = LOSS.replace("BCM", "PBCM") + f"on_vehicle_loss: restart\nfaults:\n  - {fault}\n"
    found = load(write_log(tmp_path / "run.mcap", text.replace("error: 0", "error: 0.1")))
    spread = found.estimate["ahead_gap_std"][:, 2]
    assert np.isnan(spread[20:40]).all()
    assert spread[40] == pytest.approx(spread[0], rel=0.1)
    assert spread[40] > 2.0 * spread[19]
    # Until its first command takes effect the new vehicle rolls.
    assert found.truth["acceleration"][22:41, 2] == pytest.approx(np.zeros(19), abs=1e-9)


def test_a_frozen_vehicle_keeps_its_last_command(tmp_path: Path) -> None:
    fault = "{type: process-frozen, vehicles: 3, at_s: 2.5, duration_s: 2}"
    brake = "events: [{vehicle: 2, at_s: 2, duration_s: 2, deceleration_mps2: 3}]\n"
    found = in_process(tmp_path, fault, brake)
    acceleration = found.truth["acceleration"][:, 2]
    commanded = found.command["acceleration"][24, 2]
    effective_s = found.command["effective_ns"][24, 2] * 1e-9
    first = int(np.ceil(round(effective_s / 0.1, 6))) + 1  # a whole cycle under it
    np.testing.assert_allclose(acceleration[first:46], commanded, atol=1e-9)
    assert commanded < -0.1
    assert np.isnan(found.command["acceleration"][25:45, 2]).all()
    assert np.isfinite(found.command["acceleration"][45:, 2]).all()


def test_a_slowed_vehicle_acts_later_and_in_order(tmp_path: Path) -> None:
    fault = "{type: process-slowed, vehicles: 3, at_s: 2, duration_s: 1, delay_ms: 250}"
    found = in_process(tmp_path, fault)
    decided_ns, effective_ns = found.command["time_ns"], found.command["effective_ns"]
    delay_ns = effective_ns[:, 2] - effective_ns[:, 1]
    slow = (decided_ns >= 2_000_000_000) & (decided_ns < 3_000_000_000)
    assert set(delay_ns[slow].tolist()) == {250_000_000}
    assert (np.diff(effective_ns[:, 2]) >= 0).all()
    assert delay_ns[~slow].max() < 250_000_000
    assert (delay_ns[decided_ns >= 3_300_000_000] == 0).all()


@pytest.mark.parametrize(
    ("settings", "fault", "line"),
    [
        (
            {},
            {"type": "process-killed", "at_s": 0.0},
            "faults.0.at_s: 0 is before the first cycle, so there is no process yet; allowed: "
            "later",
        ),
        (
            {"on_vehicle_loss": "restart"},
            {"type": "process-killed"},
            "faults.0.duration_s: missing; on_vehicle_loss is restart, which needs it",
        ),
        (
            {"on_vehicle_loss": "coast"},
            {"type": "process-killed", "duration_s": 2.0},
            "faults.0.duration_s: 2 is given, but on_vehicle_loss is coast, so no process comes "
            "back; allowed: null",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(
    settings: dict[str, Any], fault: dict[str, Any], line: str
) -> None:
    with pytest.raises(ValueError, match="faults") as refused:
        scenario_with([{"vehicles": 3, "at_s": 1.0, **fault}], **settings)
    assert line in str(refused.value)


@pytest.mark.parametrize("policy", ["coast", "restart"])
def test_all_vehicles_may_be_gone_at_once(tmp_path: Path, policy: str) -> None:
    lasts = ", duration_s: 1" if policy == "restart" else ""
    fault = f"{{type: process-killed, vehicles: all, at_s: 2{lasts}}}"
    text = f"{LOSS.replace('6', '4')}on_vehicle_loss: {policy}\nfaults: [{fault}]\n"
    logs = {name: run(tmp_path / name, text, *options) for name, options in ENGINES.items()}
    assert len({log.result["fingerprint"] for log in logs.values()}) == 1
    assert logs["alone"].result["cycles"] == "40"


def test_a_guest_does_not_fail_on_purpose(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(LOSS + KILLED)
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--without", "3")
    assert (outcome.code, outcome.err.strip()) == (
        2,
        "--without 3: faults.0 (process-killed) is of its process; allowed: vehicles without "
        "faults of processes",
    )


def test_a_process_fails_one_way_at_a_time() -> None:
    faults = [
        {"type": "process-frozen", "vehicles": "2-4", "at_s": 1.0, "duration_s": 5.0},
        {"type": "process-frozen", "vehicles": "4", "at_s": 3.0, "duration_s": 1.0},
    ]
    with pytest.raises(ValueError, match=r"faults\.1: begins while faults\.0 has the same vehicle"):
        scenario_with(faults)
