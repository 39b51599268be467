"""Vehicles of a process that run as arrays take all that they can hold, and refuse the rest."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.bundles import pack
from zenvoy.bus.deliveries import Delivery
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.refusals import ABSURD, FOREIGN, MISTIMED
from zenvoy.bus.topics import RECEIVE, SENSE
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.scenarios import load
from zenvoy.vehicles.shared_arrays import ArrayVehicles

PBCM: Final = "{duration_s: 4, fleet: {size: 4}, control: {model: PBCM, v2v_wait_ms: 20}}"


def delivery(beacon: pb.Beacon, **changes: Any) -> bytes:
    """Return what vehicle 1 of 4 receives in cycle 5 from vehicle 2, a cycle after it was sent."""
    columns: dict[str, Any] = {
        "cycle": 5,
        "vehicle": np.arange(1, 5),
        "time_ns": np.full(4, 520_000_000),
        "ends": np.array([1, 1, 1, 1]),
        "arrived_ns": np.array([410_000_000]),
        "beacon": np.array([0]),
        "source": np.array([2]),
        "beacons": [beacon.SerializeToString()],
    }
    return Delivery(**(columns | changes)).encode()


@pytest.fixture
def agent(tmp_path: Path) -> ArrayVehicles:
    (tmp_path / "s.yaml").write_text(PBCM)
    process = VehicleProcess("vehicles-01-04", (1, 2, 3, 4))
    return ArrayVehicles(load(tmp_path / "s.yaml").scenario, process)


BEACON_OF_2: Final = pb.Beacon(
    vehicle=2,
    cycle=4,
    time_ns=400_000_000,
    sequence=4,
    position=1.0,
    speed=30.0,
    acceleration=0.1,
    ahead=pb.Link(gap=30.0, speed=0.1),
    planned_from_ns=[400_000_000],
    planned_acceleration=[0.5],
)


def changed(*, without: str = "", **changes: Any) -> pb.Beacon:
    """Return the beacon of vehicle 2 with more or fewer fields."""
    beacon = pb.Beacon()
    beacon.CopyFrom(BEACON_OF_2)
    beacon.MergeFrom(pb.Beacon(**changes))
    if without:
        beacon.ClearField(without)  # type: ignore[arg-type]  # the stub lists the names
    return beacon


@pytest.mark.parametrize(
    "wrong",
    [
        changed(planned_from_ns=[450_000_000], planned_acceleration=[0.5]),
        changed(commanded_acceleration=1.0),
        changed(time_ns=400_000_001),
        changed(time_ns=600_000_000),
        changed(speed=float("nan")),
        changed(vehicle=3),
        changed(without="ahead"),
        changed(without="planned_from_ns"),
    ],
    ids=["plan", "command", "time", "later", "nan", "sender", "no radar", "no plan"],
)
def test_arrays_refuse_beacons_that_they_cannot_hold(
    agent: ArrayVehicles, wrong: pb.Beacon
) -> None:
    decode = agent.decoders[RECEIVE]
    good = decode(delivery(BEACON_OF_2))
    assert (agent.fault_in(RECEIVE, 0, good), good.cycle) == (None, 5)
    assert agent.fault_in(RECEIVE, 0, decode(delivery(wrong))) == ABSURD


def test_arrays_refuse_receives_of_others(agent: ArrayVehicles) -> None:
    decode = agent.decoders[RECEIVE]
    others = decode(delivery(BEACON_OF_2, vehicle=np.arange(2, 6)))
    assert agent.fault_in(RECEIVE, 0, others) == FOREIGN
    late = decode(delivery(BEACON_OF_2, time_ns=np.full(4, 530_000_000)))
    assert agent.fault_in(RECEIVE, 0, late) == MISTIMED


def senses(**changes: Any) -> list[tuple[int, bytes]]:
    flat = FlatEncoder(pb.Sense.DESCRIPTOR, ("wall_start_ns",))
    values = {**dict.fromkeys(flat.names, 1.0), "cycle": 5, "time_ns": 500_000_000, **changes}
    return [(vehicle, flat.encode(**values | {"vehicle": vehicle})) for vehicle in range(1, 5)]


def test_arrays_take_the_senses_of_all_vehicles(agent: ArrayVehicles) -> None:
    decode = agent.decoders[SENSE]
    good = decode(pack(senses()))
    assert (agent.fault_in(SENSE, 0, good), good.cycle) == (None, 5)
    assert agent.fault_in(SENSE, 0, decode(pack(senses(time_ns=1)))) == MISTIMED
    assert agent.fault_in(SENSE, 0, decode(pack(senses(ahead_gap=float("inf"))))) == ABSURD
    blind = [(1, pb.Sense(vehicle=1, cycle=5, time_ns=500_000_000).SerializeToString())]
    one_of_another_cycle = [*senses()[:3], *senses(cycle=6, time_ns=600_000_000)[3:]]
    swapped = [(1, senses()[1][1]), *senses()[1:]]
    for wrong in (senses()[:3], blind + senses()[1:], one_of_another_cycle, swapped):
        with pytest.raises(PayloadError):
            decode(pack(wrong))
