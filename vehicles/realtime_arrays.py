"""The vehicles of a shared process in real time, as arrays: all sense and decide at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from zenvoy.bus import deliveries
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Decoder, Envelope
from zenvoy.bus.bundles import unpack
from zenvoy.bus.packed import PackedCodec, encode_bytes
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.refusals import STALE
from zenvoy.bus.topics import RECEIVE, SENSE, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.array_agent import VehicleArrays
from zenvoy.vehicles.arrays.arrivals import Arrivals, Arriving, by_receiver
from zenvoy.vehicles.arrays.senses import Sensed
from zenvoy.vehicles.realtime import SETTLE_NS
from zenvoy.vehicles.seen_frames import SeenFrames

_TIMING: Final = PackedCodec(pb.Timing.DESCRIPTOR)
_TIMING_OF_COMMAND: Final = pb.Command.TIMING_FIELD_NUMBER


class RealtimeArrayVehicles:
    """Sends what `RealtimeVehicles` sends, for the vehicles that `arrays.suited` allows.

    Arrays step through every cycle. If the process is stopped for longer than a cycle, it goes
    through the missed ones without sending anything, and continues with the newest senses. A cycle
    whose senses never arrive counts as one with the readings of the next.
    """

    role = "vehicle"
    done = False
    sends_together = False
    may_wait = frozenset({RECEIVE})

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        self._core: Final = VehicleArrays(scenario, process)
        self._arriving: Final = Arriving(self._core.hearing, self.vehicles, scenario.fleet.size)
        self.decoders: Mapping[Topic[Any], Decoder] = {SENSE: self._sensed, RECEIVE: self._heard}
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._settle_ns = round(SETTLE_NS * scenario.speed)
        self._cycle = -1  # of the newest senses
        self._senses: list[Post] = []  # until their beacons are sent, the oldest first
        self._sensed_ns = 0
        self._decides_ns: int | None = None  # deadline of the decision that is due
        self._received: list[Post] = []  # since the last decision
        self._seen = SeenFrames()

    @property
    def due_ns(self) -> int | None:
        """When to send beacons; if there are none to send, when to decide."""
        if not self._senses:
            return self._decides_ns
        newest = self._senses[-1]
        is_old = newest.came_ns - newest.message.time_ns > self._period_ns
        return newest.came_ns + self._settle_ns if is_old else newest.came_ns

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Sensed | Arrivals) -> str | None:
        """Return why messages are refused, or None, as a vehicle of its own does."""
        return message.fault

    def take_in(self, post: Post) -> str | None:
        """Keep senses, and keep each frame once; return why a message is refused."""
        if post.topic is RECEIVE:
            arrivals: Arrivals = post.message
            if not self._seen.are_new(arrivals.identity.tolist(), arrivals.arrived_ns.tolist()):
                return STALE
            self._received.append(post)
            return None
        if post.message.cycle <= self._cycle:
            return STALE
        self._cycle = post.message.cycle
        self._senses.append(post)
        return None

    def act(self, now_ns: int) -> list[Envelope]:
        """Return the beacons or the commands, whichever are due; raises LawError."""
        if self._senses:
            *missed, newest = self._senses
            self._senses.clear()
            for post in missed:
                self._sense(post)
            return self._sense(newest)
        deadline_ns = self._decides_ns
        assert deadline_ns is not None
        if now_ns - max(deadline_ns, self._sensed_ns) > self._period_ns:
            self._pass_by()  # the process was stopped; it continues with newer senses
            return []
        received = self._take_out(deadline_ns)
        sent = self._core.decide()
        head = _TIMING.encode(sensed_ns=self._sensed_ns, decided_ns=now_ns)
        ends, columns = by_receiver([(one.message, one.came_ns) for one in received], len(sent))
        each = _TIMING.encode_each(ends, **columns)
        return [
            one._replace(payload=one.payload + encode_bytes(_TIMING_OF_COMMAND, head + frames))
            for one, frames in zip(sent, each, strict=True)
        ]

    def _sense(self, post: Post) -> list[Envelope]:
        """Begin a cycle, and go through those before it that are left; return the beacons."""
        sensed: Sensed = post.message
        while self._decides_ns is not None or self._core.cycle < sensed.cycle - 1:
            if self._decides_ns is None:
                self._core.sense(sensed.senses)
            self._pass_by()
        self._sensed_ns = post.came_ns
        self._decides_ns = sensed.time_ns + self._wait_ns
        return self._core.sense(sensed.senses)

    def _pass_by(self) -> None:
        """End a cycle without commands."""
        self._take_out(self._core.cycle * self._period_ns + self._wait_ns)
        self._core.pass_by()

    def _take_out(self, deadline_ns: int) -> list[Post]:
        """Take in the frames that count in the decision of the cycle, and return them."""
        self._decides_ns = None
        by_ns = max(deadline_ns, self._sensed_ns)
        counting = [post for post in self._received if post.came_ns <= by_ns]
        self._received = [post for post in self._received if post.came_ns > by_ns]
        self._core.hear(post.message.frames for post in counting)
        return counting

    def _sensed(self, bundle: bytes) -> Sensed:
        return self._core.sensing.read(unpack(bundle))

    def _heard(self, payload: bytes) -> Arrivals:
        return self._arriving.read(deliveries.decode(payload))
