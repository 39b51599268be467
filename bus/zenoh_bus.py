"""The Zenoh bus in lock-step: an agent steps when all messages that it waits for have arrived."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final, Protocol, TypeVar

import zenoh

from zenvoy.bus.agent import Agent, Barrier, Log, decoded_jointly, decoders_of
from zenvoy.bus.clock import pause
from zenvoy.bus.connection import Connection
from zenvoy.bus.latecomers import Latecomers
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.topics import Topic
from zenvoy.bus.watch import Blame
from zenvoy.bus.wiring import Wiring

T = TypeVar("T")

_WARY_STEPS: Final = 100  # steps after the last refused message
_ROOM_FOR_OTHERS: Final = 512  # messages of other programs that may wait in a queue
_MAX_ROUNDS: Final = 1_000  # of emptying queues that fill again, before the awaited one is read


class Wait(Protocol):
    """Returns the result of a blocking call."""

    def __call__(self, receive: Callable[[], T], /) -> T: ...


class ZenohBus(Connection):
    """Drives an agent in lock-step: it steps when all messages that it waits for have arrived.

    The bus waits for one stream at a time. Zenoh's thread for a link blocks while the queue of
    another stream is full. A fleet cannot fill a queue, but a program that floods a key can. So all
    queues are emptied when messages are refused, or when nothing arrives.
    """

    def __init__(self, agent: Agent, wiring: Wiring, log: Log | None = None) -> None:
        self._mailbox = Mailbox(agent.fault_in, decoders_of(agent))
        super().__init__(agent, wiring, log)
        self._agent = agent
        self._barrier: Barrier | None = None
        self._awaited_topic: Topic[Any] | None = None
        self._joining = False  # whether it waits for processes that join
        self._starts: defaultdict[str, int] = defaultdict(lambda: 1)  # of processes, awaited
        self._wary = 0  # number of coming steps in which all queues are watched
        self._refused = 0
        self._wait: Wait = self._watch.wait
        if self._latecomers is not None:
            self._wait = partial(self._latecomers.timed, self._watch.wait)

    def run(self) -> None:
        """Step the agent until it is done; raises StoppedError or StalledError."""
        agent, mailbox, refusals = self._agent, self._mailbox, self.refusals
        while (barrier := agent.barrier) is not None:
            self._barrier = barrier
            mailbox.expect(barrier)
            if refusals.total != self._refused:
                self._refused, self._wary = refusals.total, _WARY_STEPS
            if self._wary:
                self._collect_warily(barrier)
            else:
                self._collect(barrier)
            if barrier.joins:
                self._wait_for_joining(barrier.joins)
            self._watch.progressed()
            inbox = mailbox.take(barrier)
            if self._latecomers is not None:
                inbox.late = self._latecomers.ended()
            self.send(agent.step(barrier.now_ns, inbox))

    def _collect(self, barrier: Barrier) -> None:
        has, wait = self._mailbox.has, self._wait
        for topic, ids in barrier.needs:
            receive = self._subscribers[topic].recv
            self._awaited_topic = topic
            while not has(topic, barrier.cycle, len(ids)):
                self._take_in(topic, wait(receive))
        self._awaited_topic = None

    def _collect_warily(self, barrier: Barrier) -> None:
        """Collect the messages of a barrier by polling all queues, not waiting for one stream."""
        self._wary -= 1
        met, wait = self._mailbox.met, self._wait
        self._empty_queues()
        while not met(barrier):
            wait(pause)
            self._empty_queues()

    def _wait_for_joining(self, vehicles: Sequence[int]) -> None:
        """Wait until the next process of each vehicle is ready, so that it misses no message."""
        self._joining = True
        for vehicle in vehicles:
            name = self._streams.process("vehicle", vehicle)
            if vehicle in self._shared_by:
                continue  # its process goes on, and has a new agent for it
            self._starts[name] += 1
            self._awaited = Blame(f"the start of {name}", (name,))
            while self._presence.started[name] < self._starts[name]:
                self._watch.wait(pause)
                self._presence.note()
        self._joining = False

    def _empty_queues(self, but: Topic[Any] | None = None) -> bool:
        """Empty the queues of all topics except `but`, and return whether they held anything."""
        found = False
        for topic, subscriber in self._subscribers.items():
            if topic is but:
                continue
            for _ in range(self._capacity):  # later arrivals are left for the next call
                if (sample := subscriber.try_recv()) is None:
                    break
                self._take_in(topic, sample)
                found = True
        if self._barrier is not None:  # before the first step, `_wait_for_tokens` reads them
            self._presence.note()
        return found

    def _idle(self) -> None:
        """Empty the queues that are not being read, because a full one may block Zenoh.

        The awaited queue is left alone: `_collect` blocks on it, and would not notice a message
        taken from it here until the next one arrives.
        """
        super()._idle()
        for _ in range(_MAX_ROUNDS):
            if not self._empty_queues(but=self._awaited_topic):
                break
            self._watch.wait(pause)

    def _take_in(self, topic: Topic[Any], sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        parcels = self._admission.parcels(topic, key, sample)
        message = decoded_jointly(self._joint_decoders.get(topic), parcels)
        together = message is not None and self._mailbox.put_together(topic, message, parcels)
        for vehicle, payload in parcels:
            reason = None if together else self._mailbox.put(topic, vehicle, payload)
            if reason is not None:
                self.refusals.add(reason, key)
            elif self._latecomers is not None and topic.writer == "vehicle":
                self._note_arrival(self._latecomers, topic, vehicle)

    def _note_arrival(self, latecomers: Latecomers, topic: Topic[Any], vehicle: int) -> None:
        """Note a message for the current barrier; one for a later cycle keeps nobody waiting."""
        barrier = self._barrier
        if barrier is not None and self._mailbox.holds(topic, barrier.cycle, vehicle):
            latecomers.came(vehicle)

    def _handler(self, topic: Topic[Any]) -> zenoh.handlers.FifoChannel[zenoh.Sample]:
        return zenoh.handlers.FifoChannel(self._capacity)

    @property
    def _capacity(self) -> int:
        """The number of messages of a topic that may wait to be read."""
        return 8 * len(self._wiring.vehicles) + _ROOM_FOR_OTHERS

    def _blame(self, in_any_case: bool) -> Blame | None:
        """Return what is missing; None if the world is late and may still report the stall."""
        if self._barrier is None:
            return super()._blame(in_any_case)
        if self._joining:
            return self._awaited
        missing = self._mailbox.missing(self._barrier)
        if not in_any_case and any(topic.writer == "world" for topic, _ in missing):
            return None
        culprits = dict.fromkeys(self._streams.process(topic.writer, one) for topic, one in missing)
        return Blame(self._mailbox.describe_missing(self._barrier), tuple(culprits))
