"""The channel: takes frames in, delivers what arrives, tells what became of each."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS
from zenvoy.channel.access import Access
from zenvoy.channel.conditions import Conditions, Way
from zenvoy.channel.delivery import Air
from zenvoy.channel.frames import Fate, Medium, fates
from zenvoy.channel.in_order import InOrder
from zenvoy.channel.outages import Outages
from zenvoy.channel.pairs import Pairs, pairs
from zenvoy.channel.rows import Rows, Scene
from zenvoy.channel.technologies import TECHNOLOGIES
from zenvoy.scenarios import Scenario

Floats = NDArray[np.float64]

_FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)


class ChannelAgent:
    """One step per cycle: beacons in; receives for the vehicles, links for the world out.

    With v2v_wait 0 the delivery of cycle k holds what arrived by t_k, all of it sent earlier: it
    goes out as soon as the beacons of cycle k - 1 are in, and the first one at once.
    """

    role = "channel"
    name = "channel"
    vehicle = 0

    def __init__(self, scenario: Scenario) -> None:
        channel, size = scenario.channel, scenario.fleet.size
        self._cycles = scenario.cycles
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._ring_length_m = scenario.ring_length_m
        self._vehicles = range(1, size + 1)
        self._access = Access(scenario) if channel.medium.access == "csma" else None
        self._medium = Medium(
            technology=TECHNOLOGIES[channel.technology],
            on_air_ns=None if self._access is None else self._access.on_air_ns,
            frame_bytes=channel.frame_bytes,
            bit_rate_mbps=channel.bit_rate_mbps,
        )
        self._conditions = Conditions(scenario)
        self._duplicates = channel.duplicate > 0.0
        self._in_order = InOrder(size)
        self._outages = Outages(scenario)
        self._ahead = 0 if self._wait_ns else 1  # cycles by which a delivery runs ahead
        self._cycle = -self._ahead
        self._air = Air(size)

    @property
    def barrier(self) -> Barrier | None:
        """Positions and all beacons of the cycle."""
        if self._cycle == self._cycles:
            return None
        if self._cycle < 0:
            return Barrier(0, 0)
        # The one before the many: a stall is blamed on what is not in, and they are taken in turn.
        needs = ((POSITIONS, (0,)), (BEACON, self._vehicles))
        return Barrier(self._cycle * self._period_ns + self._wait_ns, self._cycle, needs)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Decide the fate of the cycle's frames and deliver what is due."""
        links = [self._transmit(inbox)] if self._cycle >= 0 else []
        delivery = self._cycle + self._ahead
        self._cycle += 1
        if delivery == self._cycles:
            return links
        return self._air.deliver(delivery, delivery * self._period_ns + self._wait_ns) + links

    def _transmit(self, inbox: Inbox) -> Envelope:
        """Put a cycle's frames on the air; returns what becomes of them."""
        positions = inbox.one(POSITIONS)
        sent_ns = positions.time_ns
        beacons = inbox.all(BEACON)
        sequence = np.array([beacon.sequence for beacon in beacons], dtype=np.int64)
        position = np.array(positions.position)
        reach = pairs(position, self._medium.technology.range_m, self._ring_length_m)
        speaks = np.array([not beacon.silent for beacon in beacons])
        if self._access is not None:
            speaks = self._access.allowed(speaks, sent_ns)
        if not speaks.all():
            reach = reach.only(speaks[reach.source])
        rows = Rows(reach.source, reach.destination, reach.distance, sequence[reach.source])
        scene = Scene(self._cycle, sent_ns, position, self._ring_length_m)
        way, busy_ratio = self._conditions.of(rows, scene), None
        if self._access is not None:
            airing = self._access.air(rows, speaks, sequence, scene)
            latency_ns = way.latency_ns + airing.wait_ns[rows.source]
            way = way._replace(latency_ns=latency_ns, collided=airing.collided)
            busy_ratio = airing.busy_ratio
        fate = self._fate(reach, rows, way, scene)
        if self._duplicates:
            rows, fate = self._with_copies(reach, rows, fate, scene)
        self._air.send(inbox.payloads(BEACON), rows.source, rows.destination, fate.arrived_ns)
        return _links(self._cycle, sent_ns, rows, fate, busy_ratio)

    def _fate(self, reach: Pairs, rows: Rows, way: Way, scene: Scene) -> Fate:
        outages = self._outages.lost(rows.source, rows.destination, scene.position, scene.sent_ns)
        if outages is not None:
            way = way._replace(lost=way.lost | outages)
        return self._settled(reach, way, scene.sent_ns)

    def _settled(self, reach: Pairs, way: Way, sent_ns: int) -> Fate:
        deadline_ns = sent_ns + self._ahead * self._period_ns + self._wait_ns
        return fates(reach, way, sent_ns, deadline_ns, self._medium, self._in_order)

    def _with_copies(self, reach: Pairs, rows: Rows, fate: Fate, scene: Scene) -> tuple[Rows, Fate]:
        """The frames, and after them the second copies of some that get through."""
        through = fate.arrived_ns >= 0
        twice, way = self._conditions.copies(rows.only(through), scene)
        through[through] = twice
        copies = self._settled(reach.only(through), way, scene.sent_ns)
        copies.outcome[:] = pb.OUTCOME_DUPLICATE
        return (
            Rows._make(_joined(rows, rows.only(through))),
            Fate._make(_joined(fate, copies)),
        )


def _joined(
    first: tuple[NDArray[Any], ...], second: tuple[NDArray[Any], ...]
) -> list[NDArray[Any]]:
    """Tables one below the other, column by column."""
    return [np.concatenate(pair) for pair in zip(first, second, strict=True)]


def _links(cycle: int, sent_ns: int, rows: Rows, fate: Fate, busy_ratio: Floats | None) -> Envelope:
    frames = _FRAMES.encode(
        cycle=cycle,
        time_ns=sent_ns,
        source=rows.source + 1,
        destination=rows.destination + 1,
        sequence=rows.sequence,
        sent_ns=np.full(len(rows.source), sent_ns),
        arrived_ns=fate.arrived_ns,
        latency_ns=fate.latency_ns,
        distance=rows.distance,
        outcome=fate.outcome,
        **({} if busy_ratio is None else {"busy_ratio": busy_ratio}),
    )
    links = pb.Links(cycle=cycle, time_ns=sent_ns, frames=frames)
    return Envelope(LINKS, 0, links.SerializeToString())
