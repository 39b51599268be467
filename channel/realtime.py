"""The channel in real time: takes beacons as they come, delivers frames when they are due."""

from __future__ import annotations

from typing import Any, Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.realtime import Post
from zenvoy.bus.refusals import STALE
from zenvoy.bus.topics import POSITIONS, Topic
from zenvoy.channel.agent import Channel, Sent
from zenvoy.channel.gathering import Gathering
from zenvoy.scenarios import Scenario

_WINDOW_NS: Final = 1_000_000  # of wall time: frames that are due within it come in one message
_KEPT: Final = 5  # cycles for which positions are kept, for beacons that are late


class RealtimeChannel:
    """Puts frames on the air when `gathering` says so, and delivers each of them when it is due.

    What becomes of a frame is drawn as in lock-step, by seed, link and sequence number. It is
    delivered at its own instant, or up to a millisecond later together with others to the same
    vehicle: a message costs some 60 µs, and 40 vehicles send 15,600 frames per second.
    """

    role = "channel"
    name = "channel"
    vehicles = ()
    done = False
    sends_together = False
    may_wait: frozenset[Topic[Any]] = frozenset()

    def __init__(self, scenario: Scenario) -> None:
        self._core = Channel(scenario)
        self._gathering = Gathering(scenario, self._core.least_latency_ns)
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._window_ns = round(_WINDOW_NS * scenario.speed)
        self._positions: dict[int, pb.Positions] = {}  # by cycle, the newest ones
        self._batch: tuple[int, list[Envelope]] | None = None  # what is delivered next, and when

    @property
    def due_ns(self) -> int | None:
        """When to deliver a batch, to transmit beacons, or at once to prepare the next batch."""
        if self._batch is None and self._core.air.next_ns is not None:
            return 0  # which has passed: it prepares the next batch at once
        delivers = () if self._batch is None else (self._batch[0],)
        return min((*delivers, *self._transmissions().values()), default=None)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """As in lock-step."""
        return self._core.fault_in(topic, vehicle, message)

    def take_in(self, post: Post) -> str | None:
        """Keep positions, and beacons until their frames go on the air."""
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
        beacon = Sent(post.message, post.payload)
        # Beacons of a cycle may come before its positions, but not before those of the last one.
        is_new = cycle <= newest + 1 and self._gathering.add(
            cycle, post.vehicle, beacon, post.came_ns
        )
        return None if is_new else STALE

    def act(self, now_ns: int) -> list[Envelope]:
        """Do the first of these that is due: deliver a batch, transmit a cycle, prepare a batch.

        A batch is prepared ahead of its instant, since encoding it takes time. Its frames stay in
        flight until it is delivered: a transmission discards it, and it is prepared anew.
        """
        if self._batch is not None and self._batch[0] <= now_ns:
            (at_ns, receives), self._batch = self._batch, None
            self._core.air.landed(at_ns)
            return receives
        due = [cycle for cycle, at_ns in self._transmissions().items() if at_ns <= now_ns]
        if due:
            self._batch = None  # a new frame may be due before those
            return [self._transmit(min(due))]
        arrives_ns = self._core.air.next_ns
        if self._batch is None and arrives_ns is not None:
            until_ns = min(arrives_ns + self._window_ns, self._decision_ns(arrives_ns))
            cycle, until_ns = now_ns // self._period_ns, max(until_ns, now_ns)
            self._batch = self._core.air.batch(cycle, until_ns)
        return []

    def _decision_ns(self, arrives_ns: int) -> int:
        """When vehicles decide next: no frame may miss that only because it waits for others.

        The first t_k + v2v_wait that is not before the arrival.
        """
        cycle = -(-(arrives_ns - self._wait_ns) // self._period_ns)
        return cycle * self._period_ns + self._wait_ns

    def _transmissions(self) -> dict[int, int]:
        """When the waiting beacons of each cycle go on the air, at the latest; by cycle.

        Without positions nobody knows who is in range: beacons wait for those in any case.
        """
        return {
            cycle: self._gathering.transmits_ns(cycle)
            for cycle in self._gathering.cycles
            if cycle in self._positions
        }

    def _transmit(self, cycle: int) -> Envelope:
        return self._core.transmit(self._positions[cycle], self._gathering.take_out(cycle))
