"""Beacons that are read together are those that would be read one by one."""

from __future__ import annotations

from math import inf, nan

from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.checks import fault_in_beacon
from zenvoy.channel.beacons import BeaconReader
from zenvoy.channel.sent import Sent

PERIOD_NS = 100_000_000
BAD = (nan, inf, -inf)


@st.composite
def beacons(draw: st.DrawFn) -> pb.Beacon:
    """Draw a beacon of vehicle 1 to 3 in cycle 5 or another, nearly always a good one."""

    def mostly(good: int, bad: int) -> int:
        return draw(st.sampled_from([good] * 30 + [bad]))

    cycle = mostly(5, 6)
    beacon = pb.Beacon(
        cycle=cycle,
        time_ns=mostly(cycle, 4) * PERIOD_NS,
        vehicle=draw(st.integers(1, 3)),
        sequence=mostly(draw(st.integers(0, 5)), 7),
        speed=draw(st.floats(0.0, 40.0)),
        silent=draw(st.booleans()),
    )
    planned = 0 if beacon.silent else draw(st.integers(1, 3))
    beacon.planned_from_ns.extend([beacon.time_ns] * mostly(planned, 1))
    beacon.planned_acceleration.extend([1.0] * mostly(planned, 2))
    if draw(st.booleans()):
        beacon.ahead.gap = draw(st.floats(1.0, 9.0))
    if draw(st.booleans()):
        good = draw(st.one_of(st.floats(-1e3, 1e3), st.just(1e-300)))
        beacon.commanded_acceleration = draw(st.sampled_from([good] * 30 + [*BAD]))
    return beacon


@given(st.lists(beacons(), min_size=1, max_size=5, unique_by=lambda one: one.vehicle))
def test_they_are_read_together_unless_one_would_be_refused(given_beacons: list[pb.Beacon]) -> None:
    parcels = [(one.vehicle, one.SerializeToString()) for one in given_beacons]
    found = BeaconReader(PERIOD_NS).together(parcels)
    faults = [fault_in_beacon(one, one.vehicle, one.cycle * PERIOD_NS) for one in given_beacons]
    cycles = {one.cycle for one in given_beacons}
    if any(faults) or len(cycles) > 1:
        assert found is None
        return
    assert found is not None
    assert (found.cycle, found.time_ns) == (given_beacons[0].cycle, given_beacons[0].time_ns)
    pairs = zip(parcels, given_beacons, strict=True)
    assert found.sent == {vehicle: Sent.of(one, payload) for (vehicle, payload), one in pairs}


@given(beacons(), st.integers(1, 3))
def test_a_beacon_of_another_vehicle_is_left_to_the_checks(beacon: pb.Beacon, owner: int) -> None:
    payload = beacon.SerializeToString()
    found = BeaconReader(PERIOD_NS).together([(owner, payload)])
    fault = fault_in_beacon(beacon, owner, beacon.cycle * PERIOD_NS)
    assert (found is None) == (fault is not None)
