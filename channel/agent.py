"""The channel: takes frames in, delivers what arrives, tells what became of each."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import BEACON, LINKS, POSITIONS, RECEIVE
from zenvoy.channel.frames import Fate, Medium, fates
from zenvoy.channel.pairs import Pairs, pairs
from zenvoy.channel.technologies import TECHNOLOGIES
from zenvoy.scenarios import Scenario

_FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)
# Columns of the frames in flight: source and destination (from 1), sequence, arrival.
_SOURCE, _DESTINATION, _SEQUENCE, _ARRIVED = range(4)


class ChannelAgent:
    """One step per cycle: beacons in; receives for the vehicles, links for the world out.

    With v2v_wait 0 the delivery of cycle k holds what arrived by t_k, all of it sent earlier: it
    goes out as soon as the beacons of cycle k - 1 are in, and the first one at once.
    """

    role = "channel"
    name = "channel"
    vehicle = 0

    def __init__(self, scenario: Scenario) -> None:
        channel = scenario.channel
        self._size, self._cycles = scenario.fleet.size, scenario.cycles
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._ring_length_m = scenario.ring_length_m
        self._vehicles = range(1, self._size + 1)
        self._medium = Medium(
            technology=TECHNOLOGIES[channel.technology],
            seed=scenario.seed,
            loss=channel.loss.p,
            frame_bytes=channel.frame_bytes,
            bit_rate_mbps=channel.bit_rate_mbps,
        )
        self._ahead = 0 if self._wait_ns else 1  # cycles by which a delivery runs ahead
        self._cycle = -self._ahead
        self._flying: NDArray[np.int64] = np.zeros((4, 0), dtype=np.int64)
        self._payloads: dict[tuple[int, int], bytes] = {}

    @property
    def barrier(self) -> Barrier | None:
        """Positions and all beacons of the cycle."""
        if self._cycle == self._cycles:
            return None
        if self._cycle < 0:
            return Barrier(0, 0)
        needs = ((BEACON, self._vehicles), (POSITIONS, (0,)))
        return Barrier(self._cycle * self._period_ns + self._wait_ns, self._cycle, needs)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Decide the fate of the cycle's frames and deliver what is due."""
        links: list[Envelope] = []
        if self._cycle >= 0:
            links = [self._transmit(inbox.all(BEACON), inbox.one(POSITIONS))]
        delivery = self._cycle + self._ahead
        self._cycle += 1
        return (self._deliver(delivery) if delivery < self._cycles else []) + links

    def _transmit(self, beacons: list[pb.Beacon], positions: pb.Positions) -> Envelope:
        """Put a cycle's frames on the air; returns what becomes of them."""
        sequence = np.array([beacon.sequence for beacon in beacons], dtype=np.int64)
        for beacon in beacons:
            self._payloads[beacon.vehicle, beacon.sequence] = beacon.SerializeToString()
        sent_ns = positions.time_ns
        position = np.array(positions.position)
        reach = pairs(position, self._medium.technology.range_m, self._ring_length_m)
        deadline_ns = sent_ns + self._ahead * self._period_ns + self._wait_ns
        fate = fates(reach, sequence, sent_ns, deadline_ns, self._medium)
        arrives = fate.arrived_ns >= 0
        rows = (reach.source + 1, reach.destination + 1, sequence[reach.source], fate.arrived_ns)
        self._flying = np.concatenate([self._flying, np.stack(rows)[:, arrives]], axis=1)
        return _links(self._cycle, sent_ns, reach, sequence, fate)

    def _deliver(self, cycle: int) -> list[Envelope]:
        """Receives of a cycle: for each vehicle what has arrived by then, in order of arrival."""
        until_ns = cycle * self._period_ns + self._wait_ns
        due = self._flying[:, self._flying[_ARRIVED] <= until_ns]
        self._flying = self._flying[:, self._flying[_ARRIVED] > until_ns]
        due = due[:, np.lexsort((due[_SEQUENCE], due[_SOURCE], due[_ARRIVED], due[_DESTINATION]))]
        bounds = np.searchsorted(due[_DESTINATION], np.arange(1, self._size + 2)).tolist()
        source, _, sequence, arrived_ns = due.tolist()
        payloads = self._payloads
        receives = []
        for vehicle in self._vehicles:
            rows = slice(bounds[vehicle - 1], bounds[vehicle])
            keys = zip(source[rows], sequence[rows], strict=True)
            receive = pb.Receive(
                cycle=cycle,
                time_ns=until_ns,
                vehicle=vehicle,
                source=source[rows],
                arrived_ns=arrived_ns[rows],
                beacon=[payloads[key] for key in keys],
            )
            receives.append(Envelope(RECEIVE, vehicle, receive.SerializeToString()))
        self._forget_landed()
        return receives

    def _forget_landed(self) -> None:
        if self._flying.shape[1] == 0:
            self._payloads.clear()
            return
        source, _, sequence, _ = self._flying.tolist()
        flying = set(zip(source, sequence, strict=True))
        self._payloads = {key: self._payloads[key] for key in self._payloads if key in flying}


def _links(cycle: int, sent_ns: int, reach: Pairs, sequence: NDArray[Any], fate: Fate) -> Envelope:
    frames = _FRAMES.encode(
        cycle=cycle,
        time_ns=sent_ns,
        source=reach.source + 1,
        destination=reach.destination + 1,
        sequence=sequence[reach.source],
        sent_ns=np.full(len(reach.source), sent_ns),
        arrived_ns=fate.arrived_ns,
        latency_ns=fate.latency_ns,
        distance=reach.distance,
        outcome=fate.outcome,
    )
    links = pb.Links(cycle=cycle, time_ns=sent_ns, frames=frames)
    return Envelope(LINKS, 0, links.SerializeToString())
