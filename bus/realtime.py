"""The Zenoh bus in real time: an agent acts on time, whether or not messages are missing.

One rule decides lateness everywhere: a message counts for a deadline if it arrived by then, even if
the process reads it later. The loop, its queue and its clock apply this rule together, so they
share a module, although it is long.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from queue import Empty
from typing import Any, Final, NamedTuple

import zenoh

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope, Log, decoded_jointly
from zenvoy.bus.arrivals import Arrivals
from zenvoy.bus.clock import WallTime, wall_ns
from zenvoy.bus.clock_bounds import Offset
from zenvoy.bus.connection import Connection
from zenvoy.bus.errors import PayloadError, StalledError
from zenvoy.bus.far_clock import FarClock, measured
from zenvoy.bus.realtime_agent import ROUNDING_NS, Post, RealtimeAgent, admit
from zenvoy.bus.refusals import MALFORMED, MISTIMED, OVERFLOW
from zenvoy.bus.topics import COMMAND, TOPICS, Topic
from zenvoy.bus.wiring import Wiring

_FOR_EVER_S: Final = 1e9
_WAIT_S: Final = 0.5
_LEAD_NS: Final = 100_000_000  # from setting the start to the first cycle
_AT_ONCE_NS: Final = 10_000_000_000  # the greatest delay of a message that sets time 0
_MOST_QUEUED: Final = 10_000  # messages; more are dropped, as the transport would do
_MOST_EARLY: Final = 1_000
_TELL_START: Final = frozenset(
    topic for topic in TOPICS if "wall_start_ns" in topic.message.DESCRIPTOR.fields_by_name
)


class _Sample(NamedTuple):
    """A sample, and when Zenoh handed it over (ns of wall time)."""

    came_ns: int
    topic: Topic[Any]
    sample: zenoh.Sample


class RealtimeBus(Connection):
    """Drives an agent in real time: it takes in the messages that arrived in time, and acts."""

    realtime = True

    def __init__(
        self, agent: RealtimeAgent, wiring: Wiring, speed: float, log: Log | None = None
    ) -> None:
        super().__init__(agent, wiring, log)
        self._agent = agent
        self._speed = speed
        # A message may seem to arrive early by the errors of clocks.
        self._early_ns = ROUNDING_NS + wiring.clock_error_ns
        self._most_early_ns = round(self._early_ns * max(1.0, speed))  # of simulation time
        self._start_ns: int | None = None  # time 0 on the world's clock
        self._far: FarClock | None = None
        self._offset = Offset(0, 0)  # of the world's clock
        self._wall: WallTime | None = None
        self._came = Arrivals[_Sample]()
        self._next: _Sample | None = None
        # Messages before the start was known, with wall times, and their keys.
        self._early: list[tuple[Post, str]] = []

    def start(self) -> int:
        """Set time 0 to shortly after now, and return it in ns of wall time.

        Only the process that sets the time, the world, calls this.
        """
        start_ns = wall_ns() + _LEAD_NS
        self._set_start(start_ns)
        return start_ns

    def _set_start(self, start_ns: int) -> WallTime:
        """Set time 0, given on the world's clock, and return it on the own one."""
        self._start_ns = start_ns
        self._wall = WallTime(start_ns - self._offset.ns, self._speed)
        return self._wall

    def _wait_for_tokens(self) -> None:
        """Wait for the others, and begin to measure the clock of a world on another machine."""
        super()._wait_for_tokens()
        if not self._wiring.far:
            return
        limit_s = self._wiring.stall_limit_s or _FOR_EVER_S
        run = self._wiring.run
        first = self._watch.wait(lambda: measured(self.session, run, limit_s))
        if first is None:
            raise StalledError("the world does not tell its time", ("world",))
        self._offset, self._far = first, FarClock(self.session, run)

    def _keep_time(self) -> None:
        """Follow the clock of a world on another machine."""
        offset = None if self._far is None else self._far.offset()
        if offset is not None:
            self._offset = offset
            if self._start_ns is not None:
                self._set_start(self._start_ns)

    def send(self, envelopes: Iterable[Envelope]) -> None:
        """Send messages; commands also say how well this machine knows the world's clock."""
        if self._far is not None:
            timing = pb.Timing(
                clock_offset_ns=self._offset.ns, clock_error_ns=self._offset.error_ns
            )
            more = pb.Command(timing=timing).SerializeToString()  # joins the timing that is there
            envelopes = [
                one._replace(payload=one.payload + more) if one.topic is COMMAND else one
                for one in envelopes
            ]
        super().send(envelopes)

    @property
    def now_ns(self) -> int:
        """The simulation time; 0 before the start."""
        return 0 if self._wall is None else self._wall.time_ns(wall_ns())

    def run(self, after_turn: Callable[[], None] = lambda: None) -> None:
        """Let the agent act until it is done; raises StoppedError or StalledError.

        `after_turn` is called after each message and each act.
        """
        self._watch.ignore_stalls()
        while not self._agent.done:
            self.turn()
            after_turn()

    def turn(self) -> None:
        """Wait for the next message or the next due time, whichever is first, and handle it."""
        agent = self._agent
        self._keep_time()
        due_ns = agent.due_ns
        until_ns = None if due_ns is None or self._wall is None else self._wall.wall_ns(due_ns)
        sample = self._peek(until_ns)
        if sample is not None and (until_ns is None or sample.came_ns <= until_ns):
            self._next = None
            self._hear(sample)
            return
        self.send(self._acts())

    def _acts(self) -> list[Envelope]:
        """Let the agent act, and return what it sends; with `sends_together`, for all acts due."""
        agent = self._agent
        sent = agent.act(self.now_ns)
        while agent.sends_together and agent.due_ns is not None and agent.due_ns <= self.now_ns:
            sent += agent.act(self.now_ns)
        return sent

    def _peek(self, until_ns: int | None) -> _Sample | None:
        """Return the first sample that arrives by `until_ns` of wall time, or None."""
        if self._next is None:
            try:
                self._next = self._watch.wait(lambda: self._take(until_ns))
            except Empty:
                return None
        return self._next

    def _take(self, until_ns: int | None) -> _Sample:
        """Return the next sample in the queue.

        Raises Empty after `until_ns`. If that is None, the process waits for the world to set time
        0, and StalledError is raised after the stall limit.
        """
        if until_ns is not None:
            return self._came.get(until_ns)
        limit_s = self._wiring.stall_limit_s or _FOR_EVER_S
        # Short waits: a request to end that arrives just before a wait is seen only after it, and a
        # process that was stopped past the limit still finds what has arrived in the meantime.
        for _ in range(math.ceil(limit_s / _WAIT_S)):
            self._keep_time()
            try:
                return self._came.get(wall_ns() + round(min(limit_s, _WAIT_S) * 1e9))
            except Empty:
                continue
        raise StalledError(f"nothing has come from the world for {limit_s:g} s", ("world",))

    def _hear(self, sample: _Sample) -> None:
        """Hand the agent the messages in a sample, or keep them until the start is known."""
        topic, key = sample.topic, str(sample.sample.key_expr)
        decode, agent = self._decoders.get(topic, topic.decode), self._agent
        # What may tell the start is compared with the one that is known. Other messages are a
        # thousand in a sample, so what they share is computed once.
        wall = None if topic in _TELL_START else self._wall
        came_ns = sample.came_ns if wall is None else wall.time_ns(sample.came_ns)
        hand_over = self._place if wall is None else self._tell
        parcels = self._admission.parcels(topic, key, sample.sample)
        together = (
            None if wall is None else decoded_jointly(self._joint_decoders.get(topic), parcels)
        )
        if together is not None:
            self._tell(Post(topic, 0, together, b"", came_ns), key, len(parcels))
            return
        for vehicle, payload in parcels:
            try:
                message = decode(payload)
            except PayloadError:
                self.refusals.add(MALFORMED, key)
                continue
            fault = agent.fault_in(topic, vehicle, message)
            if fault is not None:
                self.refusals.add(fault, key)
                continue
            hand_over(Post(topic, vehicle, message, payload, came_ns), key)

    def _place(self, post: Post, key: str) -> None:
        """Hand a message with its wall time to the agent, now or once the start is known."""
        start_ns = getattr(post.message, "wall_start_ns", 0)
        if self._wall is None and start_ns and self._may_start(post, start_ns):
            wall, early = self._set_start(start_ns), self._early.copy()
            self._early.clear()
            for one, its_key in early:
                self._tell(_there(one, wall), its_key)
        if self._wall is None and not start_ns and len(self._early) < _MOST_EARLY:
            self._early.append((post, key))
        elif self._wall is None or start_ns not in {0, self._start_ns}:
            self.refusals.add(MISTIMED, key)
        else:
            self._tell(_there(post, self._wall), key)

    def _may_start(self, post: Post, start_ns: int) -> bool:
        """Return whether a message that sets time 0 arrived at about its own time."""
        start_here = WallTime(start_ns - self._offset.ns, self._speed)
        sent_ns = start_here.wall_ns(post.message.time_ns)
        return sent_ns - self._early_ns <= post.came_ns < sent_ns + _AT_ONCE_NS

    def _tell(self, post: Post, key: str, messages: int = 1) -> None:
        """Hand a message, or several decoded as one, with its simulation time to the agent."""
        reason = admit(self._agent, post, self._most_early_ns)
        if reason is not None:
            self.refusals.add(reason, key, messages)

    def _handler(self, topic: Topic[Any]) -> zenoh.handlers.Callback[zenoh.Sample]:
        """Return a callback that stores samples with their time of arrival.

        It runs in Zenoh's own thread, because another thread would wake up later.
        """
        came = self._came
        keep = came.put_without_waking if topic in self._agent.may_wait else came.put

        def store(sample: zenoh.Sample) -> None:
            if len(came) < _MOST_QUEUED:
                keep(_Sample(wall_ns(), topic, sample))
            else:
                self.refusals.add(OVERFLOW, topic.name)

        return zenoh.handlers.Callback(store, indirect=False)


def _there(post: Post, wall: WallTime) -> Post:
    """Return a message with its time of arrival as simulation time."""
    return post._replace(came_ns=wall.time_ns(post.came_ns))
