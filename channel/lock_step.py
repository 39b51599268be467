"""The channel in lock-step: it waits for the positions and all beacons of every cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier, Envelope, Inbox, JointDecoder
from zenvoy.bus.bundles import Parcel
from zenvoy.bus.latecomers import Late
from zenvoy.bus.refusals import FOREIGN
from zenvoy.bus.topics import BEACON, POSITIONS, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.channel.agent import Channel
from zenvoy.channel.beacons import Beacons
from zenvoy.channel.sent import Sent
from zenvoy.scenarios import Scenario, attendance


class LockStepChannel:
    """Takes the beacons of a cycle in one step; sends receives to vehicles and links to the world.

    If v2v_wait is 0, the delivery of cycle k has the frames that arrived by t_k, all sent in
    earlier cycles: it goes out once the beacons of cycle k - 1 are in. The first delivery goes out
    at once.
    """

    role = "channel"
    name = "channel"
    vehicles = ()

    def __init__(self, scenario: Scenario, shared: Sequence[VehicleProcess] = ()) -> None:
        self._core = Channel(scenario, shared)
        self._cycles = scenario.cycles
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._attendance = attendance(scenario)
        self._ahead = 0 if self._wait_ns else 1  # cycles by which a delivery runs ahead
        self._cycle = -self._ahead
        self.joint_decoders: Mapping[Topic[Any], JointDecoder] = {BEACON: self._together}

    @property
    def barrier(self) -> Barrier | None:
        """The messages that the next step needs: positions and all beacons of the cycle."""
        if self._cycle == self._cycles:
            return None
        joins = self._attendance.joining_at(self._cycle + self._ahead)
        if self._cycle < 0:
            return Barrier(0, 0, joins=joins)
        # Topics are awaited in this order, and a stall is blamed on the first missing message. So
        # the single message of the world comes before those of all vehicles.
        needs = ((POSITIONS, (0,)), (BEACON, self._attendance.there(self._cycle)))
        return Barrier(self._cycle * self._period_ns + self._wait_ns, self._cycle, needs, joins)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a message is refused, or None."""
        if topic is BEACON and not self._attendance.takes_part(vehicle, message.cycle):
            return FOREIGN
        return self._core.fault_in(topic, vehicle, message)

    def _together(self, parcels: Sequence[Parcel]) -> Beacons | None:
        """Return the beacons of the vehicles of a shared process; None if any is in doubt."""
        beacons = self._core.beacon_reader.together(parcels)
        takes_part = self._attendance.takes_part
        if beacons is None or not all(takes_part(one, beacons.cycle) for one in beacons.sent):
            return None
        return beacons

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Transmit the frames of the cycle, and deliver those that are due."""
        links = [_with(inbox.late, self._transmit(inbox))] if self._cycle >= 0 else []
        delivery = self._cycle + self._ahead
        self._cycle += 1
        if delivery == self._cycles:
            return links
        until_ns = delivery * self._period_ns + self._wait_ns
        return self._core.air.deliver(delivery, until_ns, self._attendance.there(delivery)) + links

    def _transmit(self, inbox: Inbox) -> Envelope:
        there = self._attendance.there(self._cycle)
        beacons = {
            vehicle: one.sent[vehicle] if isinstance(one, Beacons) else Sent.of(one, payload)
            for vehicle, (one, payload) in zip(there, inbox.with_payloads(BEACON), strict=True)
        }
        return self._core.transmit(inbox.one(POSITIONS), beacons)


def _with(late: Late | None, links: Envelope) -> Envelope:
    """Return links that also say which machine was late; two messages in a row are one."""
    if late is None:
        return links
    said = pb.Links(late_host=late.host, late_ns=late.by_ns)
    return links._replace(payload=links.payload + said.SerializeToString())
