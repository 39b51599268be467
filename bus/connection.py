"""One participant's place on the Zenoh bus: its streams, its readiness, what it refuses."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self, cast

import zenoh

from zenvoy.bus.agent import Envelope, Log, Participant
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.parts import MAX_PAYLOAD_BYTES, Joiner, split
from zenvoy.bus.refusals import FOREIGN, MALFORMED, Refusals
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import TOPICS, Topic, alive_key, vehicle_name
from zenvoy.bus.watch import Watch


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """Where a process listens and whom it connects to, in which run, with which fleet."""

    run: str
    vehicles: Sequence[int]
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    waits_for: tuple[str, ...] = ()  # processes that must be ready before this one says it is
    stall_limit_s: float | None = None
    absent: frozenset[int] = frozenset()  # vehicles that may join later: nobody waits for them


class Connection:
    """Subscriptions, publications and readiness of one participant.

    Use as a context: entering returns when every reader of what it writes is there, and every
    process it waits for has shown its token; then it shows its own.
    """

    live = False
    """Whether nobody waits for a reader: what one cannot take is dropped."""

    def __init__(self, participant: Participant, wiring: Wiring, log: Log | None) -> None:
        self._participant = participant
        self._wiring = wiring
        self._log = log
        self._subscribers: dict[Topic[Any], zenoh.Subscriber[Any]] = {}
        self._publishers: dict[tuple[Topic[Any], int], zenoh.Publisher] = {}
        self._vehicle_of_key = _vehicles_by_key(participant, wiring)
        self._joiner = Joiner()
        self._awaited = ""
        self._watch = Watch(wiring.stall_limit_s, self._blame, self._stuck)
        self._alive: zenoh.Subscriber[Any] | None = None
        self._tokens = deque[tuple[str, bool]](maxlen=self._most_tokens)
        names = (vehicle_name(vehicle, len(wiring.vehicles)) for vehicle in wiring.vehicles)
        self._names = frozenset({*wiring.waits_for, *names})
        self.on_open: Callable[[zenoh.Session], None] = lambda _: None
        """Called with the session before anybody is waited for."""
        self.refusals = Refusals(participant.name)
        """Messages that came and were refused."""

    @property
    def session(self) -> zenoh.Session:
        """The open session, for what is not part of the control cycle."""
        return self._session

    def __enter__(self) -> Self:
        self._watch.__enter__()
        wiring = self._wiring
        self._session = open_session(wiring.listen, wiring.connect, live=self.live)
        try:
            self.on_open(self._session)
            self._subscribe()
            self._declare_publishers()
            self._wait_for_readers()
            self._wait_for_tokens()
            token = self._session.liveliness().declare_token(
                alive_key(self._wiring.run, self._participant.name)
            )
        except BaseException as error:
            self.__exit__(type(error), error, None)
            raise
        self._token = token
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._watch.__exit__(kind, error, trace)
        self.refusals.tell_counts()
        if error is not None:
            return  # the process is about to end, and closing may wait for a peer that is frozen
        self._session.close()  # type: ignore[no-untyped-call]  # zenoh's stub has no types for it

    def send(self, envelope: Envelope) -> None:
        """Log a message, publish it, or both, as its topic says."""
        topic, vehicle, payload, time_ns = envelope
        if topic.logged_as is not None and self._log is not None:
            self._log(topic, time_ns, payload)
        if topic.pattern is not None:
            self.publish(topic, payload, vehicle)

    def publish(self, topic: Topic[Any], payload: bytes, vehicle: int = 0) -> None:
        """Put a payload on the topic's key, in parts where it is too large for one message."""
        publisher = self._publishers[topic, vehicle]
        if len(payload) <= MAX_PAYLOAD_BYTES:
            publisher.put(payload)
            return
        for piece, attachment in split(payload):
            publisher.put(piece, attachment=attachment)

    def lost_processes(self) -> list[str]:
        """Processes whose tokens have gone since the last call."""
        return [name for name, there in self.comings_and_goings() if not there]

    def comings_and_goings(self) -> list[tuple[str, bool]]:
        """Processes whose tokens have come (True) or gone since the last call, in that order."""
        self._note_tokens()
        found = list(self._tokens)
        self._tokens.clear()
        return found

    def _note_tokens(self) -> None:
        while self._alive is not None and (sample := self._alive.try_recv()) is not None:
            name = str(sample.key_expr).rpartition("/")[2]
            if name in self._names:  # anyone may show a token
                self._tokens.append((name, sample.kind == zenoh.SampleKind.PUT))

    def _admitted(
        self, topic: Topic[Any], key: str, sample: zenoh.Sample
    ) -> tuple[int, bytes] | None:
        """Vehicle and whole payload of what has come; None for a part, or what is refused."""
        vehicle = self._vehicle_of_key[topic].get(key)
        if vehicle is None:
            self.refusals.add(FOREIGN, key)
            return None
        payload = sample.payload.to_bytes()
        attachment = sample.attachment
        if attachment is not None:
            try:
                whole = self._joiner.join((topic, vehicle), payload, attachment.to_bytes())
            except PayloadError:
                self.refusals.add(MALFORMED, key)
                return None
            if whole is None:
                return None
            payload = whole
        if not payload:  # a message of zeros to protobuf, and all that comes of a deletion
            self.refusals.add(MALFORMED, key)
            return None
        return vehicle, payload

    @property
    def _most_tokens(self) -> int:
        """Changes of tokens that may wait to be looked at."""
        return 4 * len(self._wiring.vehicles) + 64

    def _subscribe(self) -> None:
        agent, run = self._participant, self._wiring.run
        for topic in TOPICS:
            if topic.reader == agent.role and topic.pattern is not None:
                key = topic.key(run, agent.vehicle if agent.vehicle else "*")
                handler = self._handler(topic)
                self._subscribers[topic] = self._session.declare_subscriber(key, handler)

    def _handler(self, topic: Topic[Any]) -> Any:
        """What Zenoh hands the samples of a topic to."""
        raise NotImplementedError

    def _declare_publishers(self) -> None:
        agent, wiring = self._participant, self._wiring
        full = zenoh.CongestionControl.DROP if self.live else zenoh.CongestionControl.BLOCK
        for topic in TOPICS:
            if topic.writer != agent.role or topic.pattern is None:
                continue
            if agent.vehicle:
                vehicles: Sequence[int] = (agent.vehicle,)
            else:
                vehicles = wiring.vehicles if topic.per_vehicle else (0,)
            for vehicle in vehicles:
                self._publishers[topic, vehicle] = self._session.declare_publisher(
                    topic.key(wiring.run, vehicle), congestion_control=full
                )

    def _wait_for_readers(self) -> None:
        """What is put before a subscriber matches is gone, so wait until each one does."""
        for (topic, vehicle), publisher in self._publishers.items():
            if topic.reader is None or vehicle in self._wiring.absent:
                continue
            self._awaited = f"a reader of {topic.key(self._wiring.run, vehicle)}"
            with publisher.declare_matching_listener(zenoh.handlers.FifoChannel(16)) as changes:
                # The stub types the status as a bool; it is an object with a field, always true.
                while not cast(zenoh.MatchingStatus, publisher.matching_status).matching:
                    self._watch.wait(changes.recv)
            self._watch.progressed()

    def _wait_for_tokens(self) -> None:
        absent = set(self._wiring.waits_for)
        if not absent:
            return
        self._alive = self._session.liveliness().declare_subscriber(
            alive_key(self._wiring.run),
            zenoh.handlers.FifoChannel(self._most_tokens),
            history=True,
        )
        while absent:
            self._awaited = f"the start of {', '.join(sorted(absent)[:5])}"
            sample = self._watch.wait(self._alive.recv)
            if sample.kind == zenoh.SampleKind.PUT:
                absent.discard(str(sample.key_expr).rpartition("/")[2])
                self._watch.progressed()

    def _blame(self, in_any_case: bool) -> str | None:
        """What this process waits for, or None where it should not be the one to say so."""
        return self._awaited

    def _stuck(self) -> None:
        """Called now and then while nothing comes of waiting."""


def _vehicles_by_key(participant: Participant, wiring: Wiring) -> dict[Topic[Any], dict[str, int]]:
    """Vehicles of the streams that a participant reads (0: the one for all), by exact key."""
    own = (participant.vehicle,) if participant.vehicle else wiring.vehicles
    return {
        topic: {topic.key(wiring.run, of): of for of in (own if topic.per_vehicle else (0,))}
        for topic in TOPICS
        if topic.reader == participant.role and topic.pattern is not None
    }
