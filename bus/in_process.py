"""The in-process bus: the whole fleet in one process, in a fixed order, without Zenoh."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

from zenvoy.bus.agent import Agent, Barrier, Envelope, Log, decoders_of
from zenvoy.bus.bundles import Bundle, parcels_in
from zenvoy.bus.errors import StalledError
from zenvoy.bus.mailbox import Mailbox
from zenvoy.bus.topics import Topic


class _Seat:
    """An agent, its mailbox, and the barrier that it waits for."""

    __slots__ = ("agent", "barrier", "bundles", "decoders", "mailbox", "queued")

    def __init__(self, agent: Agent) -> None:
        self.agent = agent
        self.decoders = decoders_of(agent)
        self.mailbox = Mailbox(decoders=self.decoders)
        self.bundles: dict[Topic[Any], Bundle] = {}  # that are not complete
        self.barrier: Barrier | None = None
        self.queued = False
        self.next()

    def next(self) -> None:
        """Take the barrier for which the agent waits now."""
        self.barrier = self.agent.barrier
        self.mailbox.expect(self.barrier)


class InProcessBus:
    """Runs agents until they are done; `log` takes messages to be logged, in order of sending."""

    def __init__(self, agents: Sequence[Agent], log: Log) -> None:
        self._seats = [_Seat(agent) for agent in agents]
        self._by_reader = {
            (seat.agent.role, vehicle): seat
            for seat in self._seats
            for vehicle in seat.agent.vehicles or (0,)
        }
        self._log = log
        self._ready: deque[_Seat] = deque()

    def run(self) -> None:
        """Step agents until the world is done; raises StalledError if it would wait for ever."""
        for seat in self._seats:
            self._queue_if_met(seat)
        while self._ready:
            seat = self._ready.popleft()
            seat.queued = False
            assert seat.barrier is not None
            inbox = seat.mailbox.take(seat.barrier)
            for envelope in seat.agent.step(seat.barrier.now_ns, inbox):
                self._send(envelope)
            seat.next()
            self._queue_if_met(seat)
        self._check_done()

    def _send(self, envelope: Envelope) -> None:
        topic, vehicle, payload, time_ns, bundled = envelope
        if topic.logged_as is not None:
            self._log(topic, time_ns, payload)
        if topic.reader is None:
            return
        reader = self._by_reader.get((topic.reader, vehicle if topic.reader == "vehicle" else 0))
        if reader is None:
            return
        takes_bundles = topic in reader.decoders
        if takes_bundles and not bundled:
            bundle = reader.bundles.setdefault(topic, Bundle())
            bundle.add(vehicle, payload)
            if len(bundle) < len(reader.agent.vehicles):
                return
            payload = bundle.pack()
        if takes_bundles:
            reader.mailbox.put(topic, 0, payload)
        elif bundled:
            for one, its in parcels_in(topic, payload):
                reader.mailbox.put(topic, one, its)
        else:
            reader.mailbox.put(topic, vehicle, payload)
        self._queue_if_met(reader)

    def _queue_if_met(self, seat: _Seat) -> None:
        if not seat.queued and seat.barrier is not None and seat.mailbox.met(seat.barrier):
            seat.queued = True
            self._ready.append(seat)

    def _check_done(self) -> None:
        for seat in self._seats:
            if seat.barrier is not None and self._by_reader["world", 0].barrier is not None:
                missing = seat.mailbox.describe_missing(seat.barrier)
                raise StalledError(f"{seat.agent.name} waits for {missing}")
