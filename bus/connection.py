"""Connects one participant to the Zenoh bus: its streams, its readiness, its refusals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from types import TracebackType
from typing import Any, Self, cast

import zenoh

from zenvoy.bus.admission import Admission
from zenvoy.bus.agent import Envelope, Log, Participant, decoders_of, joint_decoders_of
from zenvoy.bus.bundles import Bundle
from zenvoy.bus.doorkeeper import Doorkeeper
from zenvoy.bus.hosts import watch_hosts
from zenvoy.bus.latecomers import Latecomers
from zenvoy.bus.parts import MAX_PAYLOAD_BYTES, split
from zenvoy.bus.presence import Presence
from zenvoy.bus.refusals import Refusals
from zenvoy.bus.session import open_session
from zenvoy.bus.streams import Streams
from zenvoy.bus.topics import Topic, alive_key
from zenvoy.bus.watch import Blame, Watch
from zenvoy.bus.wiring import Wiring


class Connection(ABC):
    """Subscriptions, publications and readiness of one participant.

    Use it as a context manager. Entering waits until each publication has a reader and each process
    to wait for has declared its liveliness token. Then it declares the token of its own process.
    """

    realtime = False
    """Whether it runs in real time, so that publishers drop messages instead of waiting."""

    def __init__(self, participant: Participant, wiring: Wiring, log: Log | None) -> None:
        self._participant = participant
        self._decoders = decoders_of(participant)
        self._joint_decoders = joint_decoders_of(participant)
        self._wiring = wiring
        self._log = log
        self._subscribers: dict[Topic[Any], zenoh.Subscriber[Any]] = {}
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._streams = Streams(participant, wiring)
        self._keys, self._shared_by = self._streams.keys, self._streams.shared_by
        self.refusals = Refusals(participant.name)
        """The messages that were refused."""
        self._admission = Admission(self._streams.owners, self._decoders, self.refusals)
        self._awaited = Blame("")
        self._watch = Watch(wiring.stall_limit_s, self._blame, self._idle)
        self._presence = Presence(
            {*wiring.waits_for, *self._streams.driven}, 4 * len(wiring.vehicles) + 64
        )
        self._doorkeeper: Doorkeeper | None = None
        self._latecomers = Latecomers() if wiring.patient else None
        self._hosts: zenoh.Subscriber[None] | None = None
        self.on_open: Callable[[zenoh.Session], None] = lambda _: None
        """Called with the session before any waiting begins."""
        self.on_idle: Callable[[], None] = lambda: None
        """Called now and then during a long wait."""

    @property
    def session(self) -> zenoh.Session:
        """The open session, for use outside the control cycle."""
        return self._session

    def __enter__(self) -> Self:
        self._watch.__enter__()
        wiring = self._wiring
        if wiring.doors is not None and wiring.doors.access:
            self._doorkeeper = Doorkeeper(self._participant.name, wiring.run)
        self._session = open_session(
            wiring.listen,
            wiring.connect,
            realtime=self.realtime,
            doors=wiring.doors,
            router=wiring.router,
        )
        try:
            self.on_open(self._session)
            self._subscribe()
            self._watch_hosts()
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
        self.refusals.report_counts()
        if self._doorkeeper is not None:
            self._doorkeeper.refusals.report_counts()
        if error is not None:
            return  # the process ends anyway, and closing may wait for a frozen peer
        self._session.close()

    def send(self, envelopes: Iterable[Envelope]) -> None:
        """Log messages, publish them, or both, as their topics say, in order.

        Messages of one stream to or from a shared process are bundled. A bundle is published when
        it has a message of each vehicle, or at the end.
        """
        bundles: dict[str, Bundle] = {}
        for topic, vehicle, payload, time_ns, bundled in envelopes:
            if topic.logged_as is not None and self._log is not None:
                self._log(topic, time_ns, payload)
            key, process = self._keys.get((topic, vehicle)), self._shared_by.get(vehicle)
            if key is None:
                continue
            if process is None or bundled:
                self._publish(key, payload)
                continue
            bundle = bundles.get(key)
            if bundle is None:
                bundle = bundles[key] = Bundle()
            bundle.add(vehicle, payload)
            if len(bundle) == len(process.vehicles):
                self._publish(key, bundle.pack())
        for key, bundle in bundles.items():
            if len(bundle):
                self._publish(key, bundle.pack())

    def publish(self, topic: Topic[Any], payload: bytes) -> None:
        """Publish a payload on the key of a topic that does not belong to a vehicle."""
        self._publish(self._keys[topic, 0], payload)

    def _publish(self, key: str, payload: bytes) -> None:
        """Publish a payload on a key, in parts if it is too large for one message."""
        publisher = self._publishers[key]
        if len(payload) <= MAX_PAYLOAD_BYTES:
            publisher.put(payload)
            return
        for piece, attachment in split(payload):
            publisher.put(piece, attachment=attachment)

    def lost_processes(self) -> list[str]:
        """Return the processes whose tokens have disappeared since the last call."""
        return [name for name, there in self.comings_and_goings() if not there]

    def comings_and_goings(self) -> list[tuple[str, bool]]:
        """Return the processes whose tokens have appeared (True) or disappeared, in order.

        These are the changes since the last call.
        """
        return self._presence.changes()

    @property
    def hosts(self) -> dict[int, str]:
        """The other machine of each vehicle, as far as it is known."""
        return {} if self._latecomers is None else dict(self._latecomers.hosts)

    def _watch_hosts(self) -> None:
        """Keep the machines of vehicles, where other machines drive them."""
        if self._latecomers is None:
            return
        driven, hosts = self._streams.driven, self._latecomers.hosts
        self._hosts = watch_hosts(self._session, self._wiring.run, driven, hosts)

    def _subscribe(self) -> None:
        """Declare one subscriber for each topic, whatever the number of vehicles."""
        for topic in self._streams.owners:
            key, handler = self._streams.read(topic), self._handler(topic)
            self._subscribers[topic] = self._session.declare_subscriber(key, handler)

    @abstractmethod
    def _handler(self, topic: Topic[Any]) -> Any:
        """Return where Zenoh puts the samples of a topic: a queue or a callback.

        ZenohBus and RealtimeBus each define it. They may also extend `_blame` and `_idle`.
        """

    def _declare_publishers(self) -> None:
        full = zenoh.CongestionControl.DROP if self.realtime else zenoh.CongestionControl.BLOCK
        for key, reader in self._streams.written(self._wiring.vehicles).items():
            # A program that only looks on must not stop the run when it does not read.
            control = full if reader else zenoh.CongestionControl.DROP
            self._publishers[key] = self._session.declare_publisher(key, congestion_control=control)

    def _wait_for_readers(self) -> None:
        """Wait until each publisher has a subscriber; earlier messages would be lost."""
        present = [one for one in self._wiring.vehicles if one not in self._wiring.absent]
        for key, reader in self._streams.written(present).items():
            if not reader:
                continue
            publisher = self._publishers[key]
            self._awaited = Blame(f"a reader of {key}", (reader,))
            with publisher.declare_matching_listener(zenoh.handlers.FifoChannel(16)) as changes:
                # The stub types the status as a bool, but it is an object, which is always true.
                while not cast(zenoh.MatchingStatus, publisher.matching_status).matching:
                    self._watch.wait(changes.recv)
            self._watch.progressed()

    def _wait_for_tokens(self) -> None:
        absent = set(self._wiring.waits_for)
        if not absent:
            return
        self._presence.follow(self._session, self._wiring.run)
        while absent:
            late = sorted(absent)
            self._awaited = Blame(f"the start of {', '.join(late[:5])}", tuple(late))
            name, there = self._watch.wait(self._presence.wait)
            if there:
                absent.discard(name)
                self._watch.progressed()

    def _blame(self, in_any_case: bool) -> Blame | None:
        """Return what this process waits for; None if another process should report the stall.

        It is called when a wait has lasted for the stall limit. Before the first step, the process
        waits for a reader or for the start of another process.
        """
        return None if self._wiring.patient else self._awaited

    def _idle(self) -> None:
        """Call `on_idle` during a long wait."""
        self.on_idle()
