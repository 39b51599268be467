"""A vehicle in real time: it sends its beacon at once, and decides at its own deadline."""

from __future__ import annotations

from typing import Any, Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.checks import is_of
from zenvoy.bus.packed import PackedCodec, encode_bytes
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.refusals import ABSURD, STALE
from zenvoy.bus.topics import RECEIVE, SENSE, Topic
from zenvoy.scenarios import Scenario, attendance
from zenvoy.vehicles.agent import Vehicle
from zenvoy.vehicles.seen_frames import SeenFrames

_TIMING: Final = PackedCodec(pb.Timing.DESCRIPTOR)
_TIMING_OF_COMMAND: Final = pb.Command.TIMING_FIELD_NUMBER

# A sense older than a cycle may be the first of many that arrive after a stop: wait for the others.
SETTLE_NS: Final = 5_000_000


class RealtimeVehicle:
    """Sends its beacon on its sense, and decides at t_k + v2v_wait with the frames so far.

    If the process is stopped for longer than a cycle, it continues with the newest sense. It takes
    nothing in while the scenario freezes its process, and knows nothing of earlier cycles once a
    process has been killed. life: as for LockStepVehicle.
    """

    role = "vehicle"
    sends_together = False
    may_wait = frozenset({RECEIVE})

    def __init__(self, scenario: Scenario, vehicle: int, life: int | None = None) -> None:
        self._scenario = scenario
        self._core = Vehicle(scenario, vehicle)
        self.name = self._core.name
        self.vehicle, self.vehicles = vehicle, (vehicle,)
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._settle_ns = round(SETTLE_NS * scenario.speed)
        self._others = frozenset(range(1, scenario.fleet.size + 1)) - {vehicle}
        self._cycle = -1  # of the newest sense
        self._sense: Post | None = None  # the newest, until its beacon is sent
        self._sensed_ns = 0
        self._decides_ns: int | None = None  # deadline of the decision of the cycle
        self._received: list[Post] = []  # since the last decision
        self._seen = SeenFrames()
        self._attendance = attendance(scenario)
        lives = self._attendance.lives(vehicle)
        # The cycles with which another process begins, if this one drives the vehicle through.
        self._births = [one.start for one in lives[1:]] if life is None else []
        is_last = life is None or life == len(lives) - 1
        self._dies_ns = None if is_last else lives[life or 0].stop * self._period_ns
        self.done = False

    @property
    def due_ns(self) -> int | None:
        """When to send a beacon; if there is none to send, when to decide; or when to die."""
        acts_ns, dies_ns = self._acts_ns, self._dies_ns
        if acts_ns is None or dies_ns is None:
            return dies_ns if acts_ns is None else acts_ns
        return min(acts_ns, dies_ns)

    @property
    def _acts_ns(self) -> int | None:
        """When it sends a beacon or decides, if nothing happens to it."""
        if self._sense is None:
            return self._decides_ns
        came_ns = self._sense.came_ns
        is_old = came_ns - self._sense.message.time_ns > self._period_ns
        return came_ns + self._settle_ns if is_old else came_ns

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a message is refused, or None, as in lock-step.

        But a receive may arrive at any time, and its time is that of its last frame.
        """
        if topic is SENSE:
            return self._core.fault_in_sense(message)
        fault = self._core.fault_in_receive(message, None, message.time_ns)
        if fault is not None:
            return fault
        is_last = max(message.arrived_ns, default=message.time_ns) == message.time_ns
        frames = zip(message.source, message.beacon, strict=True)
        of_others = all(
            source in self._others and is_of(beacon, source) for source, beacon in frames
        )
        return None if is_last and of_others else ABSURD

    def take_in(self, post: Post) -> str | None:
        """Keep the newest sense, and keep each frame once; return why a message is refused."""
        if post.topic is RECEIVE:
            if not self._takes_in(post.message.time_ns):
                return None  # it is lost, and nobody is to blame
            arrived_ns = post.message.arrived_ns[:]
            frames = list(zip(post.message.source, arrived_ns, strict=True))
            is_new = self._seen.are_new(frames, arrived_ns)
            if is_new:
                self._received.append(post)
            return None if is_new else STALE
        if post.message.cycle <= self._cycle:
            return STALE
        if self._births and post.message.cycle >= self._births[0]:
            self._be_another(post.message.cycle)
        self._cycle, self._sense = post.message.cycle, post
        self._decides_ns = None  # it is too late for a decision still due
        return None

    def _takes_in(self, arrived_ns: int) -> bool:
        """Return whether a frame that arrives then finds somebody to decide on it."""
        cycle = -(-(arrived_ns - self._wait_ns) // self._period_ns)
        return self._attendance.takes_part(self.vehicle, max(0, cycle))

    def _be_another(self, cycle: int) -> None:
        """Begin anew, as the process does that takes the place of one that was killed."""
        self._births = [one for one in self._births if one > cycle]
        self._core = Vehicle(self._scenario, self.vehicle)
        self._seen = SeenFrames()
        from_ns = (cycle - 1) * self._period_ns + self._wait_ns
        self._received = [post for post in self._received if post.message.time_ns > from_ns]

    def act(self, now_ns: int) -> list[Envelope]:
        """Return the beacon or the command, whichever is due; nothing more once it is dead."""
        if self._dies_ns is not None and now_ns >= self._dies_ns:
            self.done = True
            return []
        if self._sense is not None:
            sense, self._sense = self._sense, None
            self._sensed_ns = sense.came_ns
            self._decides_ns = sense.message.time_ns + self._wait_ns
            return [self._core.sense(sense.message)]
        deadline_ns, self._decides_ns = self._decides_ns, None
        assert deadline_ns is not None
        if now_ns - max(deadline_ns, self._sensed_ns) > self._period_ns:
            return []  # the process was stopped; it continues with a newer sense
        return [self._decide(deadline_ns, now_ns)]

    def _decide(self, deadline_ns: int, now_ns: int) -> Envelope:
        """Return the command, with a report on the timing of the cycle."""
        by_ns = max(deadline_ns, self._sensed_ns)
        posts = [post for post in self._received if post.came_ns <= by_ns]
        self._received = [post for post in self._received if post.came_ns > by_ns]
        received = [post.message for post in posts]
        command = self._core.decide(deadline_ns, received)
        came_ns = [post.came_ns for post in posts for _ in range(len(post.message.source))]
        timing = _TIMING.encode(
            sensed_ns=self._sensed_ns,
            decided_ns=now_ns,
            source=[source for one in received for source in one.source],
            arrived_ns=[arrived_ns for one in received for arrived_ns in one.arrived_ns],
            came_ns=came_ns,
        )
        payload = command.payload + encode_bytes(_TIMING_OF_COMMAND, timing)
        return command._replace(payload=payload)
