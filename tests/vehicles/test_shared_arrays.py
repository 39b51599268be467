"""Vehicles of a process that run as arrays send what vehicles of their own send, byte by byte."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import pytest

from zenvoy.bus.agent import Agent, Barrier, Envelope, Inbox, decoders_of
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.topics import BEACON, COMMAND, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess, vehicle_processes
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.scenarios import Scenario, load
from zenvoy.vehicles.arrays.suited import suited
from zenvoy.vehicles.shared_arrays import ArrayVehicles
from zenvoy.vehicles.shared_process import LockStepVehicles
from zenvoy.world.lock_step import LockStepWorld

SCENARIOS: Final = {
    "late and lost": """
duration_s: 12
fleet: {size: 9}
control: {model: FM, schedule: [{at_s: 2, model: PBCM}], v2v_wait_ms: 50, system_delay_ms: 190}
channel: {technology: lte-a-pro, loss: {p: 0.3}}
events: [{vehicle: 3, at_s: 4, duration_s: 2, deceleration_mps2: 3}]
""",
    "bursts, of which some last for longer than beacons count": """
duration_s: 20
fleet: {size: 6}
control: {model: PBCM}
channel: {loss: {gilbert_elliott: {p: 0.1, r: 0.1}}}
""",
    "at hand, some on each side": """
duration_s: 4
fleet: {size: 8}
control: {model: MBCM, v2v_wait_ms: 0, system_delay_ms: 60}
channel: {loss: {p: 0.1}}
""",
    "by position": """
duration_s: 4
fleet: {size: 8}
control: {model: MBCM, neighbour_state: position}
sensors: {position_std_m: 1.5}
channel: {loss: {p: 0.1}}
""",
    "commands of others, on an open road": """
duration_s: 6
fleet:
  size: 8
  groups: [{name: a, vehicles: 5-6, model: IDM}, {name: b, vehicles: 7, model: dCACC}]
road: {type: open}
control: {model: CACC}
channel: {loss: {p: 0.2}}
events: [{vehicle: 1, at_s: 2, duration_s: 1, deceleration_mps2: 3}]
""",
    "laws that log, and beacons in turn": """
duration_s: 6
fleet: {size: 8}
control: {model: PF-CACC}
road: {type: open}
beacons: {period_ms: 200, staggered: true}
""",
}


class Spied:
    """An agent, and what it sends."""

    def __init__(self, agent: Agent, sent: dict[tuple[str, int], list[bytes]]) -> None:
        self._agent, self._sent = agent, sent
        self.name, self.role, self.vehicles = agent.name, agent.role, agent.vehicles
        self.decoders = decoders_of(agent)

    @property
    def barrier(self) -> Barrier | None:
        return self._agent.barrier

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        return self._agent.fault_in(topic, vehicle, message)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        for topic, messages in inbox._mail.items():
            for message, _ in messages:
                vehicle = 0 if self.decoders else message.vehicle
                assert self.fault_in(topic, vehicle, message) is None
        found = self._agent.step(now_ns, inbox)
        for topic, vehicle, payload, *_ in found:
            assert topic in {BEACON, COMMAND}
            self._sent.setdefault((topic.name, vehicle), []).append(payload)
        return found


def sent_by(
    scenario: Scenario, kind: type[ArrayVehicles | LockStepVehicles], per_process: int
) -> dict[tuple[str, int], list[bytes]]:
    """Return what the vehicles of a run send, by stream and vehicle."""
    sent: dict[tuple[str, int], list[bytes]] = {}
    placed: Sequence[VehicleProcess] = vehicle_processes(scenario.fleet.size, per_process)
    shared = [process for process in placed if process.is_shared]
    agents: list[Agent] = [LockStepWorld(scenario), LockStepChannel(scenario, shared)]
    agents += [Spied(kind(scenario, process), sent) for process in placed]
    InProcessBus(agents, lambda *_: None).run()
    return sent


@pytest.mark.parametrize("text", SCENARIOS.values(), ids=SCENARIOS)
def test_vehicles_as_arrays_send_the_same_bytes(tmp_path: Path, text: str) -> None:
    (tmp_path / "s.yaml").write_text(text)
    scenario = load(tmp_path / "s.yaml").scenario
    every = range(1, scenario.fleet.size + 1)
    assert suited(scenario, every, ())
    alone = sent_by(scenario, LockStepVehicles, 1)
    assert len(alone) == 2 * len(every)
    for per_process in (3, len(every)):
        together = sent_by(scenario, ArrayVehicles, per_process)
        assert together.keys() == alone.keys()
        for stream, payloads in alone.items():
            assert together[stream] == payloads, stream


SMALL: Final = "duration_s: 4\nfleet: {size: 4}\ncontrol: {model: PBCM}\n"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("faults: [{type: transmitter-silent, vehicles: 2, at_s: 1}]", "a fault"),
        ("beacons: {rule: etsi-cam}", "another filter for each vehicle"),
        ("vehicle: {actuator_lag_s: 0.5}", "plans of another form"),
        ("estimator: {kind: ekf}", "another filter"),
    ],
)
def test_other_vehicles_run_one_by_one(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "s.yaml").write_text(f"{SMALL}{text}\n")
    assert not suited(load(tmp_path / "s.yaml").scenario, (1, 2, 3, 4), ()), why


def test_vehicles_beside_a_guest_run_one_by_one(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text("duration_s: 4\nfleet: {size: 9}\ncontrol: {model: PBCM}\n")
    scenario = load(tmp_path / "s.yaml").scenario
    ours = set(range(1, 9))  # vehicle 9 is a guest, ahead of 1 on the ring
    assert not suited(scenario, (1, 2, 3), ours)
    assert suited(scenario, (4, 5, 6), ours)
    assert not suited(scenario, (7, 8), ours)
