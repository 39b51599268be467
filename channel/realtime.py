"""The channel in real time: takes beacons as they come, delivers frames when they are due."""

from __future__ import annotations

from typing import Any, Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.realtime import Post
from zenvoy.bus.refusals import STALE
from zenvoy.bus.topics import POSITIONS, Topic
from zenvoy.channel.agent import Channel, Sent
from zenvoy.scenarios import Scenario

# All in ns of wall time.
_GUARD_NS: Final = 5_000_000  # after t_k, the beacons that are there go on the air without the rest
_PREPARE_NS: Final = 3_000_000  # from putting frames on the air to being able to deliver the first
_BUSY_NS: Final = 12_000_000  # more than that, where so many are missing that it is the machine
_MANY: Final = 4
_GATHER_NS: Final = 5_000_000  # beacons that come later than the others wait for one another
_WINDOW_NS: Final = 1_000_000  # frames to one vehicle that are due within it come together
_KEPT: Final = 5  # cycles for which positions are kept, for beacons that are late


class RealtimeChannel:
    """Puts frames on the air once a cycle's beacons are in, or at the guard time at the latest.

    That is as late as it can be for the first frame to come at its instant: beacons that miss it
    cost a message more to everyone in range. Where many are missing by then, that would keep the
    others for longer than they wait: but one that is slow by itself is not waited for.

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
        self._vehicles = range(1, scenario.fleet.size + 1)
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._guard_ns = max(
            round(_GUARD_NS * scenario.speed),
            self._core.least_latency_ns - round(_PREPARE_NS * scenario.speed),
        )
        self._busy_ns = round(_BUSY_NS * scenario.speed)
        self._gather_ns = round(_GATHER_NS * scenario.speed)
        self._window_ns = round(_WINDOW_NS * scenario.speed)
        self._positions: dict[int, pb.Positions] = {}  # by cycle, the newest ones
        self._waiting: dict[int, dict[int, Sent]] = {}  # beacons by cycle and vehicle
        self._since_ns: dict[int, int] = {}  # when the first of those came, by cycle
        self._told = dict.fromkeys(self._vehicles, -1)  # cycle of the newest beacon of each
        self._cycle = -1  # the newest whose frames went on the air, who had sent one by then
        self._present = set(self._vehicles)
        self._absent = set[int]()  # and who had not, but had in the cycle before
        self._batch: tuple[int, list[Envelope]] | None = None  # what is delivered next, and when

    @property
    def due_ns(self) -> int | None:
        """When to deliver frames, or to put new ones on the air."""
        if self._batch is None and self._core.air.next_ns is not None:
            return 0  # to prepare the next delivery, whenever that is
        delivers = () if self._batch is None else (self._batch[0],)
        return min((*delivers, *self._transmissions().values()), default=None)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """As in lock-step."""
        return self._core.fault_in(topic, vehicle, message)

    def take_in(self, post: Post) -> str | None:
        """Keep positions, and beacons until their frames go on the air."""
        cycle = post.message.cycle
        newest = max(self._positions, default=-1)
        if post.topic is POSITIONS:
            if cycle in self._positions or cycle <= newest - _KEPT:
                return STALE
            self._positions[cycle] = post.message
            for of_cycle in (self._positions, self._waiting, self._since_ns):
                for old in [kept for kept in of_cycle if kept <= cycle - _KEPT]:
                    del of_cycle[old]
            return None
        if not max(self._told[post.vehicle], newest - _KEPT) < cycle <= newest + 1:
            return STALE
        self._told[post.vehicle] = cycle
        self._waiting.setdefault(cycle, {})[post.vehicle] = Sent(post.message, post.payload)
        self._since_ns.setdefault(cycle, post.came_ns)
        return None

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
        """When vehicles next decide: no frame may miss that only because it waits for others."""
        cycle = -(-(arrives_ns - self._wait_ns) // self._period_ns)
        return cycle * self._period_ns + self._wait_ns

    def _transmissions(self) -> dict[int, int]:
        """When the frames of each cycle whose beacons are waiting go on the air, at the latest."""
        return {cycle: self._airs_ns(cycle) for cycle in self._waiting if cycle in self._positions}

    def _airs_ns(self, cycle: int) -> int:
        """When the frames of a cycle whose beacons are waiting go on the air, at the latest.

        The first transmission of a cycle waits, up to the guard time, for every vehicle that was
        there in the cycle before; where many are missing, the machine is busy and it waits longer.
        Beacons that come after it wait for one another, as long as a vehicle is missing that was
        there in the cycle before. A vehicle that missed the last cycle may be gone: nobody waits
        for it.
        """
        here = self._waiting[cycle].keys()
        if cycle <= self._cycle:  # the first transmission of the cycle has been
            return self._since_ns[cycle] + (self._gather_ns if self._absent - here else 0)
        missing = len(self._present - here)
        busy_ns = self._busy_ns if missing >= _MANY else 0
        return cycle * self._period_ns + (self._guard_ns + busy_ns if missing else 0)

    def _transmit(self, cycle: int) -> Envelope:
        beacons = self._waiting.pop(cycle)
        del self._since_ns[cycle]
        if cycle > self._cycle:
            self._absent = self._present - beacons.keys()
            self._cycle, self._present = cycle, set(beacons)
        elif cycle == self._cycle:
            self._absent -= beacons.keys()
            self._present |= beacons.keys()
        return self._core.transmit(self._positions[cycle], beacons)
