"""The channel in real time: takes beacons as they arrive, delivers frames when they are due."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope, JointDecoder
from zenvoy.bus.bundles import Parcel
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.refusals import STALE
from zenvoy.bus.topics import BEACON, POSITIONS, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.channel.agent import Channel
from zenvoy.channel.beacons import Beacons
from zenvoy.channel.gathering import Gathering
from zenvoy.channel.sent import Sent
from zenvoy.scenarios import Scenario

_WINDOW_NS: Final = 1_000_000  # of wall time: frames due within it share one message
_KEPT: Final = 5  # cycles for which positions are kept, in case beacons are late


class RealtimeChannel:
    """Puts frames on the air when `gathering` says so, and delivers each frame when it is due.

    The outcome of a frame is drawn as in lock-step, by seed, link and sequence number. A frame is
    delivered at its own instant, or up to a millisecond later together with others to the same
    vehicle: a message costs about 60 µs, and 40 vehicles send 15,600 frames per second.
    """

    role = "channel"
    name = "channel"
    vehicles = ()
    done = False
    sends_together = False
    may_wait: frozenset[Topic[Any]] = frozenset()

    def __init__(self, scenario: Scenario, shared: Sequence[VehicleProcess] = ()) -> None:
        self._core = Channel(scenario, shared)
        self._gathering = Gathering(scenario, self._core.least_latency_ns)
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._window_ns = round(_WINDOW_NS * scenario.speed)
        self._positions: dict[int, pb.Positions] = {}  # by cycle, the newest ones
        self._batch: tuple[int, list[Envelope]] | None = None  # the next delivery, and its time
        self.joint_decoders: Mapping[Topic[Any], JointDecoder] = {BEACON: self._together}

    @property
    def due_ns(self) -> int | None:
        """The time of the next delivery or transmission; 0 if the next batch is to be prepared."""
        if self._batch is None and self._core.air.next_ns is not None:
            return 0  # in the past, so the next batch is prepared at once
        delivers = () if self._batch is None else (self._batch[0],)
        return min((*delivers, *self._transmissions().values()), default=None)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a message is refused, or None, as in lock-step."""
        return self._core.fault_in(topic, vehicle, message)

    def take_in(self, post: Post) -> str | None:
        """Keep positions, and keep beacons until their frames go on the air.

        Returns why a message is refused, or None.
        """
        cycle = post.message.cycle
        newest = max(self._positions, default=-1)
        if cycle <= newest - _KEPT:
            return STALE
        if post.topic is POSITIONS:
            if cycle in self._positions:
                return STALE
            self._positions[cycle] = post.message
            for old in [kept for kept in self._positions if kept <= cycle - _KEPT]:
                del self._positions[old]
            self._gathering.forget(cycle - _KEPT)
            return None
        # Beacons may arrive before the positions of their cycle, but not before those of the
        # cycle before.
        if cycle > newest + 1:
            return STALE
        if isinstance(post.message, Beacons):
            sent = post.message.sent
        else:
            sent = {post.vehicle: Sent.of(post.message, post.payload)}
        are_new = [
            self._gathering.add(cycle, vehicle, beacon, post.came_ns)
            for vehicle, beacon in sent.items()
        ]
        return None if all(are_new) else STALE

    def _together(self, parcels: Sequence[Parcel]) -> Beacons | None:
        """Return the beacons of the vehicles of a shared process; None if any is in doubt."""
        beacons = self._core.beacon_reader.together(parcels)
        is_new = beacons is not None and self._gathering.are_new(beacons.cycle, beacons.sent)
        return beacons if is_new else None

    def act(self, now_ns: int) -> list[Envelope]:
        """Do the first of these that is due: deliver a batch, transmit a cycle, prepare a batch.

        Encoding takes time, so a batch is prepared before it is due. Its frames stay in flight
        until it is delivered: a transmission discards the batch, and it is prepared again.
        """
        if self._batch is not None and self._batch[0] <= now_ns:
            (at_ns, receives), self._batch = self._batch, None
            self._core.air.landed(at_ns)
            return receives
        due = [cycle for cycle, at_ns in self._transmissions().items() if at_ns <= now_ns]
        if due:
            self._batch = None  # a new frame may be due before those of the batch
            return [self._transmit(min(due))]
        arrives_ns = self._core.air.next_ns
        if self._batch is None and arrives_ns is not None:
            until_ns = min(arrives_ns + self._window_ns, self._decision_ns(arrives_ns))
            cycle, until_ns = now_ns // self._period_ns, max(until_ns, now_ns)
            self._batch = self._core.air.batch(cycle, until_ns)
        return []

    def _decision_ns(self, arrives_ns: int) -> int:
        """Return the first t_k + v2v_wait at or after an arrival, ns, when vehicles decide next.

        A frame must not miss that decision because it waits for others.
        """
        cycle = -(-(arrives_ns - self._wait_ns) // self._period_ns)
        return cycle * self._period_ns + self._wait_ns

    def _transmissions(self) -> dict[int, int]:
        """Return by cycle the latest time at which its waiting beacons go on the air, ns.

        Cycles without positions are left out: without them the channel cannot tell who is in range.
        """
        return {
            cycle: self._gathering.transmits_ns(cycle)
            for cycle in self._gathering.cycles
            if cycle in self._positions
        }

    def _transmit(self, cycle: int) -> Envelope:
        return self._core.transmit(self._positions[cycle], self._gathering.take_out(cycle))
