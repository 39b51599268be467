"""Faulty transmitters change what goes on the air instead of the beacons of their vehicles."""

from __future__ import annotations

from typing import Any, Final

from tests.faults import scenario_with
from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.faulty_transmitters import FaultyTransmitters
from zenvoy.channel.sent import Sent

PERIOD_NS: Final = 100_000_000
WHEN: Final = {"vehicles": 2, "at_s": 0.5, "duration_s": 0.3}  # cycles 5, 6, 7


def beacon(vehicle: int, cycle: int) -> pb.Beacon:
    time_ns = cycle * PERIOD_NS
    return pb.Beacon(
        cycle=cycle,
        time_ns=time_ns,
        vehicle=vehicle,
        sequence=cycle,
        position=100.0 * vehicle + cycle,
        speed=30.0 + cycle,
        acceleration=0.5,
        ahead=pb.Link(gap=40.0, speed=1.0),
        planned_from_ns=[time_ns, time_ns + 50],
        planned_acceleration=[1.0, 2.0],
    )


def on_air(*faults: dict[str, Any]) -> dict[int, dict[int, pb.Beacon]]:
    """Return what vehicles 1 and 2 put on the air in cycles 0 to 9, by cycle and vehicle."""
    transmitters = FaultyTransmitters(scenario_with(faults))
    found: dict[int, dict[int, pb.Beacon]] = {}
    for cycle in range(10):
        sent = {v: Sent.of(b, b.SerializeToString()) for v in (1, 2) for b in [beacon(v, cycle)]}
        air = transmitters.sent(sent, cycle * PERIOD_NS)
        found[cycle] = {v: pb.Beacon.FromString(one.payload) for v, one in air.items()}
        assert all(one.sequence == cycle for one in air.values())  # fates stay their own
    return found


def assert_unchanged_elsewhere(air: dict[int, dict[int, pb.Beacon]]) -> None:
    for cycle, beacons in air.items():
        assert beacons[1] == beacon(1, cycle)
        if cycle not in {5, 6, 7}:
            assert beacons[2] == beacon(2, cycle)


def test_a_silent_one_sends_nothing() -> None:
    air = on_air({"type": "transmitter-silent", **WHEN})
    assert [cycle for cycle, beacons in air.items() if 2 not in beacons] == [5, 6, 7]
    assert_unchanged_elsewhere(air)


def test_a_repeating_one_sends_the_last_frame_before_the_fault() -> None:
    air = on_air({"type": "transmitter-repeating", **WHEN})
    assert [air[cycle][2] for cycle in (5, 6, 7)] == [beacon(2, 4)] * 3
    assert_unchanged_elsewhere(air)


def test_a_repeating_one_may_say_that_old_frames_are_new() -> None:
    air = on_air({"type": "transmitter-repeating", **WHEN, "new_times": True})
    for cycle in (5, 6, 7):
        expected = beacon(2, 4)
        expected.cycle = expected.sequence = cycle
        expected.time_ns = cycle * PERIOD_NS
        expected.planned_from_ns[:] = [cycle * PERIOD_NS, cycle * PERIOD_NS + 50]
        assert air[cycle][2] == expected
    assert_unchanged_elsewhere(air)


def test_a_lying_one_adds_its_amounts() -> None:
    lies = {"position_m": 50.0, "speed_mps": -2.0, "acceleration_mps2": 3.0, "gap_m": -10.0}
    air = on_air({"type": "transmitter-lying", **WHEN, **lies})
    for cycle in (5, 6, 7):
        true, said = beacon(2, cycle), air[cycle][2]
        assert said.position == true.position + 50.0
        assert said.speed == true.speed - 2.0
        assert (said.acceleration, said.planned_acceleration[:]) == (3.5, [4.0, 5.0])
        assert (said.ahead.gap, said.ahead.speed) == (30.0, 1.0)
    assert_unchanged_elsewhere(air)


def test_a_fault_from_the_start_repeats_the_first_frame() -> None:
    air = on_air({"type": "transmitter-repeating", "vehicles": 2, "at_s": 0})
    assert [air[cycle][2] for cycle in range(10)] == [beacon(2, 0)] * 10
