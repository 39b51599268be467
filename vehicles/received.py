"""A beacon as its receivers read it: decoded once for all receivers of a process."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from google.protobuf.message import DecodeError

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.checks import is_sane
from zenvoy.laws import Relative
from zenvoy.vehicles.odometer import Odometer


class Report(NamedTuple):
    """The part of a beacon for laws that share links.

    odometer began at since_ns. offset is that of the link to the vehicle ahead; None if there is
    none. It refers to the odometer of the vehicle ahead that began at ahead_since_ns.
    """

    odometer: Odometer
    since_ns: int
    offset: Relative | None = None
    ahead_since_ns: int = 0


class ReceivedBeacon(NamedTuple):
    """The fields of a Beacon, in m, m/s, m/s² and ns; radar: None if no vehicle is ahead of it."""

    vehicle: int
    time_ns: int
    position: float
    speed: float
    acceleration: float
    radar: Relative | None
    planned_from_ns: tuple[int, ...]
    planned_acceleration: tuple[float, ...]
    command: float | None
    """The newest command of the sender; None if it reports none."""
    report: Report | None = None
    """The part for laws that share links; None if it has none."""


@lru_cache(maxsize=128)  # in one process, every receiver reads the same bytes
def beacon_in(payload: bytes) -> ReceivedBeacon | None:
    """Return the beacon in a frame; None if it makes no sense, because anyone may send anything."""
    try:
        beacon = pb.Beacon.FromString(payload)
    except DecodeError:
        return None
    planned_from_ns, planned = beacon.planned_from_ns[:], beacon.planned_acceleration[:]
    if not is_sane(beacon) or len(planned) != len(planned_from_ns):
        return None
    return ReceivedBeacon(
        beacon.vehicle,
        beacon.time_ns,
        beacon.position,
        beacon.speed,
        beacon.acceleration,
        radar_in(beacon),
        tuple(planned_from_ns),
        tuple(planned),
        beacon.commanded_acceleration if beacon.HasField("commanded_acceleration") else None,
        _report_in(beacon),
    )


def _report_in(beacon: pb.Beacon) -> Report | None:
    """Return what a beacon reports for laws that share links."""
    if not beacon.HasField("odometer"):
        return None
    there, offset = beacon.odometer, beacon.offset
    odometer = Odometer(there.distance, there.speed)
    if not beacon.HasField("offset"):
        return Report(odometer, there.since_ns)
    found = Relative(offset.gap, offset.speed)
    return Report(odometer, there.since_ns, found, offset.ahead_since_ns)


def radar_in(source: pb.Sense | pb.Beacon) -> Relative | None:
    """Return the radar reading in a sense or a beacon; None if no vehicle is ahead."""
    if not source.HasField("ahead"):
        return None
    link = source.ahead
    return Relative(link.gap, link.speed)
