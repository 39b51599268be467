"""The channel on some links of many runs at once: the cycle in which each frame is delivered.

`transmission.Transmission` does the same for all links of one run, with the same parts. This module
is for channels without carrier sense, relays and duplicates.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.channel.conditions import Conditions
from zenvoy.channel.frames import OnAir, turns
from zenvoy.channel.in_order import InOrder
from zenvoy.channel.outages import Outages
from zenvoy.channel.pairs import pairs
from zenvoy.links.distance import distance
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import Scenario

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

NEVER: Final = -1


class Fates:
    """Decides when frames from `source` to `destination` are delivered.

    Both are indices (r,) over the vehicles of all runs.
    """

    def __init__(self, scenarios: tuple[Scenario, ...], source: Ints, destination: Ints) -> None:
        first = scenarios[0]
        channel = first.channel
        self._source, self._destination = source, destination
        self._size, self._runs = first.fleet.size, len(scenarios)
        self._period_ns, self._wait_ns = first.period_ns, first.v2v_wait_ns
        self._ring_length_m = first.ring_length_m
        self._medium = OnAir(technology=channel.radio, frame_bytes=channel.frame_bytes)
        self._conditions = Conditions(*scenarios)
        self._outages = Outages(*scenarios)
        self._in_order = InOrder(self._size * self._runs)
        self._always = self._certain(first)

    def heard(self, cycle: int, speaks: Bools, sequence: Ints, position: Floats) -> Ints | int:
        """Return the cycle in which each frame of `cycle` is delivered, (r,), or NEVER.

        It is a single number if it is the same for all frames. speaks, sequence and position (m)
        cover all vehicles, (runs · n,).
        """
        if self._always is not None and speaks.all():
            return cycle + self._always
        frames = self._frames(sequence, position)
        sent = speaks[frames.source]
        if sent.all():
            return self._cycles(cycle, frames, self._turns(position), position)
        heard = np.full(len(sent), NEVER)
        turns_of = np.broadcast_to(self._turns(position), sent.shape)[sent]
        heard[sent] = self._cycles(cycle, frames.only(sent), turns_of, position)
        return heard

    def _cycles(self, cycle: int, frames: SentFrames, turn: Ints | int, position: Floats) -> Ints:
        """Return the cycle in which each frame is delivered, (r,), or NEVER."""
        sent_ns = cycle * self._period_ns
        scene = Scene(cycle, sent_ns, position, self._ring_length_m)
        found = self._conditions.of(frames, scene)
        gone = found.lost | found.damaged | (frames.distance > self._medium.technology.range_m)
        outages = self._outages.lost(frames.source, frames.destination, position, sent_ns)
        if outages is not None:
            gone |= outages
        on_air_ns = self._medium.frame_time_ns * turn
        arrived_ns = np.where(gone, -1, sent_ns + found.latency_ns + on_air_ns)
        if found.ordered.any():
            ends = frames.source, frames.destination
            arrived_ns = self._in_order.held(*ends, arrived_ns, found.ordered)
        return np.where(gone, NEVER, self._delivered(cycle, arrived_ns))

    def _delivered(self, cycle: int, arrived_ns: Ints) -> Ints:
        """Return the cycle of the first delivery after a frame is sent and has arrived."""
        soonest = cycle if self._wait_ns else cycle + 1
        return np.maximum(soonest, -((self._wait_ns - arrived_ns) // self._period_ns))

    def _frames(self, sequence: Ints, position: Floats) -> SentFrames:
        source, destination = self._source, self._destination
        apart = distance(position[source], position[destination], self._ring_length_m)
        return SentFrames(source, destination, apart, sequence[source])

    def _turns(self, position: Floats) -> Ints | int:
        """Return the number of each frame among its sender's copies, from 1."""
        if self._medium.technology.broadcast:
            return 1
        range_m, size = self._medium.technology.range_m, self._size
        turn = np.ones((self._runs * size, size), dtype=np.int64)
        for run, there in enumerate(position.reshape(self._runs, size)):
            reach = pairs(there, range_m, self._ring_length_m)
            turn[run * size + reach.source, reach.destination] = turns(reach, broadcast=False)
        return np.asarray(turn[self._source, self._destination % size])

    def _certain(self, scenario: Scenario) -> int | None:
        """Return the number of cycles until delivery if it is the same for all frames, or None."""
        channel, length_m = scenario.channel, self._ring_length_m
        technology = self._medium.technology
        if channel.outages or length_m is None or length_m > 2.0 * technology.range_m:
            return None
        span_ns = self._conditions.certain_latencies_ns
        if span_ns is None or not technology.broadcast:
            return None
        on_air_ns = self._medium.frame_time_ns
        ends_ns = np.array([least_ns + on_air_ns for least_ns in span_ns])
        soonest, latest = self._delivered(0, ends_ns).tolist()
        return int(soonest) if soonest == latest else None
