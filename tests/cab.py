"""A cab drives the agent of one vehicle, cycle by cycle, with hand-made messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.topics import BEACON, COMMAND, RECEIVE, SENSE, Topic
from zenvoy.scenarios import Control, Fleet, Gains, Model, Road, Scenario, Sensors
from zenvoy.vehicles.lock_step import LockStepVehicle

T_NS = 100_000_000
T_S = 0.1
AHEAD, EGO, BEHIND = 2, 3, 4
USUAL = Gains()
STILL = Gains(k_d=0.0, k_v=0.0, k_c=0.0)  # commands nothing whatever it knows


def scenario(
    *,
    model: Model = "PBCM",
    gains: Gains = USUAL,
    wait_ms: float = 11.0,
    delay_ms: float = 89.0,
    age_limit_ms: float = 1_000.0,
    open_road: bool = False,
) -> Scenario:
    return Scenario(
        duration_s=10.0,
        road=Road(type="open" if open_road else "ring"),
        fleet=Fleet(size=5),
        sensors=Sensors(error=0.0),
        control=Control(
            model=model,
            gains=gains,
            v2v_wait_ms=wait_ms,
            system_delay_ms=delay_ms,
            beacon_age_limit_ms=age_limit_ms,
        ),
    )


class Cab:
    """Drives one agent by hand-made messages, cycle by cycle."""

    def __init__(self, settings: Scenario, vehicle: int = EGO) -> None:
        self.agent = LockStepVehicle(settings, vehicle)
        self.vehicle = vehicle
        self.cycle = -1
        self._mailbox = Mailbox()

    def sense(
        self,
        *,
        gap: float | None = 37.5,
        relative_speed: float = 0.0,
        speed: float = 30.0,
        acceleration: float = 0.0,
    ) -> pb.Beacon:
        """Begin a cycle, and return the beacon that the vehicle sends."""
        self.cycle += 1
        message = pb.Sense(
            cycle=self.cycle,
            time_ns=self.cycle * T_NS,
            vehicle=self.vehicle,
            ahead=None if gap is None else pb.Link(gap=gap, speed=relative_speed),
            position=1_000.0,
            speed=speed,
            acceleration=acceleration,
        )
        return BEACON.decode(self._step(SENSE, message.SerializeToString(), BEACON))

    def receive(self, beacons: Sequence[pb.Beacon] = ()) -> pb.Command:
        """End the cycle, and return the command that the vehicle decides."""
        barrier = self.agent.barrier
        assert barrier is not None
        message = pb.Receive(
            cycle=self.cycle,
            time_ns=barrier.now_ns,
            vehicle=self.vehicle,
            source=[beacon.vehicle for beacon in beacons],
            arrived_ns=[barrier.now_ns] * len(beacons),
            beacon=[beacon.SerializeToString() for beacon in beacons],
        )
        command = COMMAND.decode(self._step(RECEIVE, message.SerializeToString(), COMMAND))
        assert (command.cycle, command.time_ns) == (self.cycle, barrier.now_ns)
        return command

    def _step(self, topic: Topic[Any], payload: bytes, answers: Topic[Any]) -> bytes:
        """Hand in the one message that the agent waits for, and return its answer."""
        barrier, mailbox = self.agent.barrier, self._mailbox
        assert barrier is not None
        mailbox.put(topic, self.vehicle, payload)
        assert mailbox.met(barrier)
        (envelope,) = self.agent.step(barrier.now_ns, mailbox.take(barrier))
        assert (envelope.topic, envelope.vehicle) == (answers, self.vehicle)
        return envelope.payload


def beacon(
    vehicle: int,
    cycle: int,
    *,
    gap: float = 37.5,
    relative_speed: float = 0.0,
    speed: float = 30.0,
    acceleration: float = 0.0,
) -> pb.Beacon:
    """Return a beacon of a vehicle that plans to keep its acceleration."""
    return pb.Beacon(
        cycle=cycle,
        time_ns=cycle * T_NS,
        vehicle=vehicle,
        sequence=cycle,
        speed=speed,
        acceleration=acceleration,
        ahead=pb.Link(gap=gap, speed=relative_speed),
        planned_from_ns=[cycle * T_NS],
        planned_acceleration=[acceleration],
    )


def assert_plans(sent: pb.Beacon, *plan: tuple[int, float]) -> None:
    """Check the plan of a beacon: accelerations, m/s², and their starts, ms."""
    assert [t / 1e6 for t in sent.planned_from_ns] == [t for t, _ in plan]
    assert list(sent.planned_acceleration) == pytest.approx([a for _, a in plan], abs=1e-12)
