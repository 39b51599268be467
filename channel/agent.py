"""The channel: takes frames in, delivers what arrives, tells what became of each."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.checks import flaw_of_beacon, flaw_of_positions
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS, Topic
from zenvoy.channel.delivery import Air
from zenvoy.channel.transmission import Transmission, Transmitted
from zenvoy.links.rows import Scene
from zenvoy.scenarios import Scenario

_FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)


class ChannelAgent:
    """One step per cycle: beacons in; receives for the vehicles, links for the world out.

    With v2v_wait 0 the delivery of cycle k holds what arrived by t_k, all of it sent earlier: it
    goes out as soon as the beacons of cycle k - 1 are in, and the first one at once.
    """

    role = "channel"
    name = "channel"
    vehicles = ()

    def __init__(self, scenario: Scenario) -> None:
        size = scenario.fleet.size
        self._cycles = scenario.cycles
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._ring_length_m = scenario.ring_length_m
        self._vehicles = range(1, size + 1)
        self._transmission = Transmission(scenario)
        self._ahead = 0 if self._wait_ns else 1  # cycles by which a delivery runs ahead
        self._cycle = -self._ahead
        self.air = Air(size)

    @property
    def barrier(self) -> Barrier | None:
        """Positions and all beacons of the cycle."""
        if self._cycle == self._cycles:
            return None
        if self._cycle < 0:
            return Barrier(0, 0)
        # Topics are awaited in this order, and a stall is blamed on the first that is missing.
        # So the single message comes before those of all vehicles.
        needs = ((POSITIONS, (0,)), (BEACON, self._vehicles))
        return Barrier(self._cycle * self._period_ns + self._wait_ns, self._cycle, needs)

    def flaw(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Positions and beacons are of the start of their cycle, and of all in the fleet."""
        start_ns = message.cycle * self._period_ns
        if topic is POSITIONS:
            return flaw_of_positions(message, len(self._vehicles), start_ns)
        return flaw_of_beacon(message, vehicle, start_ns)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Transmit the cycle's frames and deliver what is due."""
        links = [self.transmit(inbox)] if self._cycle >= 0 else []
        delivery = self._cycle + self._ahead
        self._cycle += 1
        if delivery == self._cycles:
            return links
        return self.air.deliver(delivery, delivery * self._period_ns + self._wait_ns) + links

    @property
    def least_latency_ns(self) -> int:
        """No frame arrives earlier than this after it was sent."""
        return self._transmission.least_latency_ns

    def transmit(self, inbox: Inbox) -> Envelope:
        """Put the frames of the beacons in `inbox` on the air; returns what becomes of them."""
        positions = inbox.one(POSITIONS)
        beacons = inbox.all(BEACON)
        sequence = np.array([beacon.sequence for beacon in beacons], dtype=np.int64)
        speaks = np.array([not beacon.silent for beacon in beacons])
        position = np.array(positions.position)
        scene = Scene(positions.cycle, positions.time_ns, position, self._ring_length_m)
        sent = self._transmission.of(speaks, sequence, scene)
        rows = sent.rows
        self.air.send(
            inbox.payloads(BEACON), rows.source, rows.destination, sent.outcomes.arrived_ns
        )
        return _links(scene, sent)


def _links(scene: Scene, sent: Transmitted) -> Envelope:
    """What the log tells of the frames of a cycle."""
    rows, outcomes = sent.rows, sent.outcomes
    frames = _FRAMES.encode(
        cycle=scene.cycle,
        time_ns=scene.sent_ns,
        source=rows.source + 1,
        destination=rows.destination + 1,
        sequence=rows.sequence,
        sent_ns=np.full(len(rows.source), scene.sent_ns),
        arrived_ns=outcomes.arrived_ns,
        latency_ns=outcomes.latency_ns,
        distance=rows.distance,
        outcome=outcomes.outcome,
        **({} if sent.busy_ratio is None else {"busy_ratio": sent.busy_ratio}),
        **({} if sent.hops is None else {"hops": sent.hops}),
    )
    links = pb.Links(cycle=scene.cycle, time_ns=scene.sent_ns, frames=frames)
    return Envelope(LINKS, 0, links.SerializeToString())
