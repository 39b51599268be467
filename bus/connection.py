"""Connects one participant to the Zenoh bus: its streams, its readiness, its refusals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self, cast

import zenoh

from zenvoy.bus.agent import Envelope, Log, Participant, decoders_of
from zenvoy.bus.bundles import Bundle, Parcel, parcels_in
from zenvoy.bus.doorkeeper import Doorkeeper
from zenvoy.bus.doors import Doors
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.hosts import watch_hosts
from zenvoy.bus.latecomers import Latecomers
from zenvoy.bus.parts import MAX_PAYLOAD_BYTES, Joiner, split
from zenvoy.bus.refusals import FOREIGN, MALFORMED, Refusals
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import TOPICS, Topic, alive_key, vehicle_name
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.bus.watch import Blame, Watch


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """The run and fleet of a process, its endpoints, and the processes that it waits for."""

    run: str
    vehicles: Sequence[int]
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    waits_for: tuple[str, ...] = ()  # processes that must be ready before this one is
    stall_limit_s: float | None = None
    absent: frozenset[int] = frozenset()  # vehicles that may join later; nobody waits for them
    shared_processes: tuple[VehicleProcess, ...] = ()  # processes that run several vehicles each
    doors: Doors | None = None  # for TLS endpoints
    public: frozenset[str] = frozenset()  # names of the streams that observers may read
    router: bool = False  # whether it connects to a Zenoh router, and nobody listens
    patient: bool = False  # whether it waits for the others without a limit before it begins
    far: bool = False  # whether the world runs on another machine, with another clock
    clock_error_ns: int = 0  # in real time: how far the clocks of other machines may be off


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
        self._wiring = wiring
        self._log = log
        self._subscribers: dict[Topic[Any], zenoh.Subscriber[Any]] = {}
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._shared_by = {
            vehicle: process for process in wiring.shared_processes for vehicle in process.vehicles
        }
        self._keys = {
            (topic, vehicle): self._key(topic, vehicle)
            for topic in TOPICS
            if topic.is_open(wiring.public)
            for vehicle in (wiring.vehicles if topic.per_vehicle else (0,))
        }
        self._owners = self._owners_by_key()
        self._joiner = Joiner()
        self._awaited = Blame("")
        self._watch = Watch(wiring.stall_limit_s, self._blame, self._idle)
        self._alive: zenoh.Subscriber[Any] | None = None
        self._doorkeeper: Doorkeeper | None = None
        self._tokens = deque[tuple[str, bool]](maxlen=self._most_tokens)
        self._ready: set[str] = set()  # processes whose tokens are there
        self._started = Counter[str]()  # how often a process has become ready
        names = (vehicle_name(vehicle, len(wiring.vehicles)) for vehicle in wiring.vehicles)
        shared = (process.name for process in wiring.shared_processes)
        self._names = frozenset({*wiring.waits_for, *names, *shared})
        self._latecomers = Latecomers() if wiring.patient else None
        self._hosts: zenoh.Subscriber[None] | None = None
        self.on_open: Callable[[zenoh.Session], None] = lambda _: None
        """Called with the session before any waiting begins."""
        self.on_idle: Callable[[], None] = lambda: None
        """Called now and then during a long wait."""
        self.refusals = Refusals(participant.name)
        """The messages that were refused."""

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
            bundle = bundles.setdefault(key, Bundle())
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

    def _key(self, topic: Topic[Any], vehicle: int) -> str:
        """Return the key of a topic of a vehicle (0: none), or of its shared process."""
        process, run = self._shared_by.get(vehicle), self._wiring.run
        return topic.key(run, vehicle) if process is None else topic.shared_key(run, process.name)

    def lost_processes(self) -> list[str]:
        """Return the processes whose tokens have disappeared since the last call."""
        return [name for name, there in self.comings_and_goings() if not there]

    def comings_and_goings(self) -> list[tuple[str, bool]]:
        """Return the processes whose tokens have appeared (True) or disappeared, in order.

        These are the changes since the last call.
        """
        self._note_tokens()
        found = list(self._tokens)
        self._tokens.clear()
        return found

    def _note_tokens(self) -> None:
        while self._alive is not None and (sample := self._alive.try_recv()) is not None:
            name = str(sample.key_expr).rpartition("/")[2]
            if name in self._names:  # other programs may declare tokens too
                there = sample.kind == zenoh.SampleKind.PUT
                self._count_start(name, there=there)
                self._tokens.append((name, there))

    def _count_start(self, name: str, *, there: bool) -> None:
        """Note that the token of a process is there or gone; it may be reported twice."""
        if there and name not in self._ready:
            self._started[name] += 1
        if there:
            self._ready.add(name)
        else:
            self._ready.discard(name)

    def _admitted(self, topic: Topic[Any], key: str, sample: zenoh.Sample) -> Sequence[Parcel]:
        """Return the vehicles and payloads of a sample; none for a part, or if it is refused."""
        owner = self._owners[topic].get(key)
        if owner is None:
            self.refusals.add(FOREIGN, key)
            return ()
        payload = sample.payload.to_bytes()
        attachment = sample.attachment
        try:
            if attachment is not None:
                whole = self._joiner.join(key, payload, attachment.to_bytes())
                if whole is None:
                    return ()
                payload = whole
            parcels = self._parcels_in(topic, owner, payload)
        except PayloadError:
            self.refusals.add(MALFORMED, key)
            return ()
        # A deletion has an empty payload, which protobuf would read as a message of zeros.
        if not parcels or not all(payload for _, payload in parcels):
            self.refusals.add(MALFORMED, key)
            return ()
        owners = {owner} if isinstance(owner, int) else owner
        taken_apart = topic not in self._decoders
        if taken_apart and not owners.issuperset(vehicle for vehicle, _ in parcels):
            self.refusals.add(FOREIGN, key)
            return ()
        return parcels

    def _parcels_in(
        self, topic: Topic[Any], owner: int | frozenset[int], payload: bytes
    ) -> list[Parcel]:
        """Return the payloads in a message by vehicle; a bundle that stays whole has number 0."""
        if isinstance(owner, int):
            return [(owner, payload)]
        return [(0, payload)] if topic in self._decoders else parcels_in(topic, payload)

    @property
    def hosts(self) -> dict[int, str]:
        """The other machine of each vehicle, as far as it is known."""
        return {} if self._latecomers is None else dict(self._latecomers.hosts)

    def _watch_hosts(self) -> None:
        """Keep the machines of vehicles, where other machines drive them."""
        if self._latecomers is None:
            return
        vehicles = self._wiring.vehicles
        driven: dict[str, Sequence[int]] = {
            vehicle_name(one, len(vehicles)): (one,) for one in vehicles
        }
        driven |= {process.name: process.vehicles for process in self._wiring.shared_processes}
        self._hosts = watch_hosts(self._session, self._wiring.run, driven, self._latecomers.hosts)

    @property
    def _most_tokens(self) -> int:
        """The number of changes of tokens that may wait to be read."""
        return 4 * len(self._wiring.vehicles) + 64

    def _subscribe(self) -> None:
        """Declare one subscriber for each topic, whatever the number of vehicles."""
        agent, run = self._participant, self._wiring.run
        for topic in TOPICS:
            if topic.reader == agent.role and topic.pattern is not None:
                key = self._keys[topic, agent.vehicles[0]] if agent.vehicles else topic.keys(run)
                handler = self._handler(topic)
                self._subscribers[topic] = self._session.declare_subscriber(key, handler)

    @abstractmethod
    def _handler(self, topic: Topic[Any]) -> Any:
        """Return where Zenoh puts the samples of a topic: a queue or a callback.

        ZenohBus and RealtimeBus each define it. They may also extend `_blame` and `_idle`.
        """

    def _declare_publishers(self) -> None:
        full = zenoh.CongestionControl.DROP if self.realtime else zenoh.CongestionControl.BLOCK
        for key, reader in self._written(self._wiring.vehicles).items():
            # A program that only looks on must not stop the run when it does not read.
            control = full if reader else zenoh.CongestionControl.DROP
            self._publishers[key] = self._session.declare_publisher(key, congestion_control=control)

    def _written(self, fleet: Iterable[int]) -> dict[str, str]:
        """Return the keys that it writes for a fleet, each with the process that reads it.

        The process is "" if no reader is required.
        """
        agent = self._participant
        return {
            self._keys[topic, vehicle]: (
                self._process(topic.reader, vehicle) if topic.reader and topic.is_awaited else ""
            )
            for topic in TOPICS
            if topic.writer == agent.role and topic.is_open(self._wiring.public)
            for vehicle in (agent.vehicles or fleet if topic.per_vehicle else (0,))
        }

    def _wait_for_readers(self) -> None:
        """Wait until each publisher has a subscriber; earlier messages would be lost."""
        present = [one for one in self._wiring.vehicles if one not in self._wiring.absent]
        for key, reader in self._written(present).items():
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
        self._alive = self._session.liveliness().declare_subscriber(
            alive_key(self._wiring.run),
            zenoh.handlers.FifoChannel(self._most_tokens),
            history=True,
        )
        while absent:
            late = sorted(absent)
            self._awaited = Blame(f"the start of {', '.join(late[:5])}", tuple(late))
            sample = self._watch.wait(self._alive.recv)
            name = str(sample.key_expr).rpartition("/")[2]
            there = sample.kind == zenoh.SampleKind.PUT
            self._count_start(name, there=there)
            if there:
                absent.discard(name)
                self._watch.progressed()

    def _blame(self, in_any_case: bool) -> Blame | None:
        """Return what this process waits for; None if another process should report the stall.

        It is called when a wait has lasted for the stall limit. Before the first step, the process
        waits for a reader or for the start of another process.
        """
        return None if self._wiring.patient else self._awaited

    def _process(self, role: str, vehicle: int) -> str:
        """Return the name of the process of a role, or of a vehicle."""
        if role != "vehicle":
            return role
        process = self._shared_by.get(vehicle)
        return (
            vehicle_name(vehicle, len(self._wiring.vehicles)) if process is None else process.name
        )

    def _idle(self) -> None:
        """Call `on_idle` during a long wait."""
        self.on_idle()

    def _owners_by_key(self) -> dict[Topic[Any], dict[str, int | frozenset[int]]]:
        """Return the vehicle (0: none), or the set of vehicles, of each key that it reads."""
        agent = self._participant
        owners: dict[Topic[Any], dict[str, int | frozenset[int]]] = {}
        for topic in TOPICS:
            if topic.reader != agent.role or topic.pattern is None:
                continue
            streams = owners[topic] = {}
            for vehicle in (agent.vehicles or self._wiring.vehicles) if topic.per_vehicle else (0,):
                process = self._shared_by.get(vehicle)
                vehicles = vehicle if process is None else frozenset(process.vehicles)
                streams[self._keys[topic, vehicle]] = vehicles
        return owners
