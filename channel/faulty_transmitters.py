"""Faults of transmitters: what goes on the air instead of the beacons that vehicles send.

They act where the channel takes beacons in, so vehicles know nothing of them, and a vehicle of any
program has them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.sent import Sent
from zenvoy.scenarios import (
    Fault,
    Scenario,
    TransmitterLying,
    TransmitterRepeating,
    TransmitterSilent,
    all_faults,
)


class _Effect(Protocol):
    """Returns what goes on the air instead of a beacon; None for nothing.

    It is asked for every beacon of its vehicles, in force or not.
    """

    def __call__(self, sent: Sent, in_force: bool) -> Sent | None: ...


class FaultyTransmitters:
    """The faults of a scenario's transmitters, in the order of the scenario."""

    def __init__(self, scenario: Scenario) -> None:
        self._effects: dict[int, list[tuple[Fault, _Effect]]] = {}  # by vehicle
        for _, fault, vehicles in all_faults(scenario):
            for vehicle in vehicles:
                effect = _effect(fault)
                if effect is not None:
                    self._effects.setdefault(vehicle, []).append((fault, effect))

    def sent(self, beacons: Mapping[int, Sent], now_ns: int) -> dict[int, Sent]:
        """Return what goes on the air at `now_ns`, by vehicle.

        beacons: what the vehicles send, none of it silent.
        """
        on_air = dict(beacons)
        for vehicle in self._effects.keys() & beacons.keys():
            beacon: Sent | None = beacons[vehicle]
            for fault, effect in self._effects[vehicle]:
                if beacon is not None:
                    beacon = effect(beacon, fault.in_force(now_ns))
            if beacon is None:
                del on_air[vehicle]
            else:
                on_air[vehicle] = beacon
        return on_air


def _effect(fault: Fault) -> _Effect | None:
    match fault:
        case TransmitterSilent():
            return _silent
        case TransmitterRepeating():
            return _Repeating(new_times=fault.new_times)
        case TransmitterLying():
            return _Lying(fault)
        case _:
            return None  # a fault of something else


def _silent(sent: Sent, in_force: bool) -> Sent | None:
    return None if in_force else sent


class _Repeating:
    """Sends the contents of an earlier beacon; number and fate are those of the new one."""

    def __init__(self, *, new_times: bool) -> None:
        self._new_times = new_times
        self._newest: Sent | None = None

    def __call__(self, sent: Sent, in_force: bool) -> Sent | None:
        if not in_force or self._newest is None:
            self._newest = sent
            return sent
        if not self._new_times:
            return sent._replace(payload=self._newest.payload)
        return sent._replace(payload=_renewed(self._newest.payload, sent))


def _renewed(old: bytes, now: Sent) -> bytes:
    """Return an old beacon as if it were of now: its plan begins as much later as the beacon."""
    beacon = pb.Beacon.FromString(old)
    later_ns = now.time_ns - beacon.time_ns
    beacon.cycle, beacon.time_ns, beacon.sequence = now.cycle, now.time_ns, now.sequence
    planned_from_ns = [time_ns + later_ns for time_ns in beacon.planned_from_ns]
    beacon.planned_from_ns[:] = planned_from_ns
    return beacon.SerializeToString()


class _Lying:
    """Adds amounts to the values of a beacon."""

    def __init__(self, fault: TransmitterLying) -> None:
        self._by = fault

    def __call__(self, sent: Sent, in_force: bool) -> Sent | None:
        if not in_force:
            return sent
        beacon, by = pb.Beacon.FromString(sent.payload), self._by
        beacon.position += by.position_m
        beacon.speed += by.speed_mps
        beacon.acceleration += by.acceleration_mps2
        planned = [value + by.acceleration_mps2 for value in beacon.planned_acceleration]
        beacon.planned_acceleration[:] = planned
        if beacon.HasField("commanded_acceleration"):
            beacon.commanded_acceleration += by.acceleration_mps2
        if beacon.HasField("ahead"):
            beacon.ahead.gap += by.gap_m
        return sent._replace(payload=beacon.SerializeToString())
