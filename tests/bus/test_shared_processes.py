"""Vehicles that share a process bundle their messages, and write the same log as alone."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any, Final

import pytest

from tests.conftest import command, run, wait_until, zenvoy
from tests.streamed_log import Log, read_log
from tests.virtual_time import Logged, VirtualBus, in_lock_step, realtime_agents
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Agent
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.realtime_agent import RealtimeAgent
from zenvoy.bus.topics import Topic
from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.channel.realtime import RealtimeChannel
from zenvoy.fleet.per_process import per_process_of
from zenvoy.scenarios import Scenario, load
from zenvoy.vehicles.shared_process import LockStepVehicles, RealtimeVehicles
from zenvoy.world.lock_step import LockStepWorld
from zenvoy.world.realtime import RealtimeWorld

LATE_AND_LOST: Final = """
duration_s: 12
fleet: {size: 7}
control: {model: FM, schedule: [{at_s: 2, model: PBCM}], v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
events: [{vehicle: 3, at_s: 4, duration_s: 2, deceleration_mps2: 3}]
"""
AT_HAND: Final = """
duration_s: 4
fleet: {size: 8}
control: {model: MBCM, v2v_wait_ms: 0, system_delay_ms: 60}
channel: {loss: {p: 0.1}}
"""
# Far longer than any test waits.
LONG: Final = """
duration_s: 100000
clock: realtime
fleet: {size: 5}
control: {beacon_age_limit_ms: 500}
"""


def scenario(folder: Path, text: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load(folder / "s.yaml").scenario


def events(folder: Path) -> list[tuple[int, int, str]]:
    """Return kind, vehicle and text of the events of a run so far."""
    log = read_log(folder / "out" / "run.mcap")
    found = [pb.Event.FromString(message.data) for message in log.of("/events")]
    return [(event.kind, event.vehicle, event.text) for event in found]


def silent(folder: Path) -> set[int]:
    """Return the vehicles that send no command now."""
    found: set[int] = set()
    for kind, vehicle, _ in events(folder):
        if kind == pb.EVENT_SILENT:
            found.add(vehicle)
        elif kind == pb.EVENT_SILENT_END:
            found.discard(vehicle)
    return found


@pytest.mark.parametrize("text", [LATE_AND_LOST, AT_HAND], ids=["late and lost", "at hand"])
@pytest.mark.parametrize("per_process", [2, 7])
def test_agents_together_are_agents_alone(tmp_path: Path, text: str, per_process: int) -> None:
    settings = scenario(tmp_path, text)
    placed = vehicle_processes(settings.fleet.size, per_process)
    logged: Logged = []

    def log(topic: Topic[Any], time_ns: int, payload: bytes) -> None:
        assert topic.logged_as is not None
        logged.append((topic.logged_as, time_ns, payload))

    shared = [process for process in placed if process.is_shared]
    agents: list[Agent] = [LockStepWorld(settings), LockStepChannel(settings, shared)]
    agents += [LockStepVehicles(settings, process) for process in placed]
    InProcessBus(agents, log).run()
    assert logged == in_lock_step(settings)


@pytest.mark.parametrize("text", [LATE_AND_LOST, AT_HAND], ids=["late and lost", "at hand"])
def test_in_real_time_agents_together_are_agents_alone(tmp_path: Path, text: str) -> None:
    settings = scenario(tmp_path, text)
    alone = VirtualBus(realtime_agents(settings))
    alone.run()
    placed = vehicle_processes(settings.fleet.size, 3)
    agents: list[RealtimeAgent] = [RealtimeChannel(settings), RealtimeWorld(settings)]
    together = VirtualBus([*agents, *(RealtimeVehicles(settings, process) for process in placed)])
    together.run()
    assert together.logged == alone.logged


def fingerprint(log: Log) -> str:
    assert log.result["end"] == "complete"
    return log.result["fingerprint"]


def test_processes_of_several_give_the_same_bits(tmp_path: Path) -> None:
    """The last vehicle is alone, since 7 is no multiple of 2."""
    alone = fingerprint(run(tmp_path / "alone", LATE_AND_LOST, "--bus", "in-process"))
    for per_process in ("2", "auto", "40"):
        number = per_process_of(per_process, 7)
        folder = tmp_path / per_process
        log = run(folder, LATE_AND_LOST, "--vehicles-per-process", per_process)
        assert fingerprint(log) == alone
        assert log.metadata["zenvoy.run"]["vehicles_per_process"] == str(number)
        logs = list((folder / "out" / "logs").iterdir())
        names = {f"{process.name}.log" for process in vehicle_processes(7, number)}
        assert names <= {file.name for file in logs}
        assert [file.name for file in logs if file.read_text()] == []  # nothing was refused


def test_a_bundle_that_is_too_large_goes_in_several_messages(tmp_path: Path) -> None:
    """45 vehicles are in range of one another, so all receives have 45 · 44 beacons."""
    large = "duration_s: 2\nfleet: {size: 45}\ncontrol: {model: BCM}"
    alone = run(tmp_path / "alone", large, "--bus", "in-process")
    together = run(tmp_path / "together", large, "--vehicles-per-process", "45")
    assert fingerprint(together) == fingerprint(alone)


def test_a_process_of_several_that_dies_is_lost_and_the_run_goes_on(tmp_path: Path) -> None:
    (tmp_path / "long.yaml").write_text(LONG)
    options = ("--vehicles-per-process", "2", "--without", "5")
    with command(tmp_path, "run", "long.yaml", "--out", "out", *options) as started:
        names = {"world", "channel", "vehicles-01-02", "vehicles-03-04"}
        started.wait_for_children(names)
        assert started.children().keys() == names
        started.wait_for_cycles(tmp_path / "out" / "run.mcap")
        started.send_to_child("vehicles-01-02", signal.SIGKILL)
        lost = {
            (pb.EVENT_PROCESS_LOST, 0, "vehicles-01-02"),
            (pb.EVENT_SILENT, 1, ""),
            (pb.EVENT_SILENT, 2, ""),
        }
        wait_until(lambda: lost <= set(events(tmp_path)), "both vehicles are missed")
        (tmp_path / "2").mkdir()
        outcome = zenvoy(tmp_path / "2", "vehicle", "--id", "2", "--run", "../out")
        assert (outcome.code, outcome.err) == (
            2,
            "--id 2: shares the process vehicles-01-02, which it cannot leave; allowed: a vehicle "
            "that has a process of its own, or that --without left out\n",
        )
        (tmp_path / "5").mkdir()
        with command(tmp_path / "5", "vehicle", "--id", "5", "--run", "../out") as joined:
            here = [(pb.EVENT_PROCESS_BACK, 0, "vehicle-05"), (pb.EVENT_SILENT_END, 5, "")]
            wait_until(lambda: set(here) <= set(events(tmp_path)), "vehicle 5 has joined")
            # A busy machine may hold up the others, too, but they go on.
            wait_until(lambda: silent(tmp_path) == {1, 2}, "all other vehicles drive")
            started.send(signal.SIGTERM)
            outcome = started.wait()
            assert joined.wait().code == 0
        assert started.left() == []
    assert outcome.code == 130
    assert outcome.err.startswith("vehicles-01-02 died: killed by SIGKILL; the run goes on\n")
    found = events(tmp_path)
    assert {text for kind, _, text in found if kind == pb.EVENT_PROCESS_LOST} == {"vehicles-01-02"}
    assert (pb.EVENT_SILENT, 5, "") in found  # it was not there at first


def test_in_lock_step_a_process_of_several_that_dies_ends_the_run(tmp_path: Path) -> None:
    (tmp_path / "long.yaml").write_text(LONG.replace("realtime", "lock-step"))
    options = ("--vehicles-per-process", "3")
    with command(tmp_path, "run", "long.yaml", "--out", "out", *options) as started:
        started.wait_for_children({"world", "channel", "vehicles-01-03", "vehicles-04-05"})
        started.wait_for_cycles(tmp_path / "out" / "run.mcap")
        started.send_to_child("vehicles-04-05", signal.SIGKILL)
        outcome = started.wait()
        assert started.left() == []
    assert (outcome.code, outcome.err) == (3, "vehicles-04-05 died: killed by SIGKILL\n")
    assert (pb.EVENT_PROCESS_LOST, 0, "vehicles-04-05") in events(tmp_path)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ("0", "is not at least 1"),
        ("many", "is no number of vehicles; allowed: 1 or more, or auto"),
    ],
)
def test_no_number_of_vehicles_per_process_is_refused(tmp_path: Path, given: str, why: str) -> None:
    outcome = zenvoy(tmp_path, "run", "quickstart", "--vehicles-per-process", given)
    assert (outcome.code, outcome.err) == (2, f"--vehicles-per-process {given}: {why}\n")
    assert list(tmp_path.glob("runs")) == []
