"""A fleet of processes includes an attacker, which sends mutated messages to all the others.

    python -m tests.attack SCENARIO.yaml OUT MUTANTS_PER_CYCLE VEHICLES_PER_PROCESS

Vehicles listen nowhere, and peers do not relay, so here vehicles also connect to the attacker. It
receives all messages. In each cycle it sends random bytes and mutants of real messages. It never
sends a message that could pass for a real one: without keys, nobody can distinguish a whole body of
the present cycle with a true head.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final, NamedTuple

import zenoh
from google.protobuf.message import DecodeError

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.bundles import pack, unpack
from zenvoy.bus.mailbox import WINDOW
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import BEACON, COMMAND, LINKS, POSITIONS, RECEIVE, SENSE, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess, vehicle_processes
from zenvoy.fleet.ends import Death
from zenvoy.fleet.folder import make_folder
from zenvoy.fleet.guests import endpoints_of
from zenvoy.fleet.labels import labels_of
from zenvoy.fleet.spawn import Program
from zenvoy.fleet.supervisor import Supervisor
from zenvoy.fleet.table import process_table
from zenvoy.scenarios import load
from zenvoy.vehicles.process import run_vehicle, run_vehicles

READ: Final = (SENSE, BEACON, RECEIVE, COMMAND, POSITIONS, LINKS)
MARK: Final = 2.8125
"""m/s², in what is made up; no controller decides exactly that."""
FIRST_CYCLE: Final = 12


def streams(run: str, size: int) -> dict[str, tuple[Topic[Any], int]]:
    """Return topic and vehicle (0: none) of every stream that has a reader, by key."""
    return {
        topic.key(run, vehicle): (topic, vehicle)
        for topic in READ
        for vehicle in (range(1, size + 1) if topic.per_vehicle else (0,))
    }


class Seen(NamedTuple):
    """A real message."""

    topic: Topic[Any]
    vehicle: int
    payload: bytes
    cycle: int


class Mutant(NamedTuple):
    """A message of the attacker. A payload of None is a deletion."""

    key: str
    payload: bytes | None
    attachment: bytes | None = None


class Mutator:
    """Makes mutants of the messages that it sees, for a fleet of `size`."""

    def __init__(self, run: str, size: int, seed: int) -> None:
        self._run, self._size = run, size
        self._random = random.Random(seed)
        self._seen: deque[Seen] = deque(maxlen=4_000)
        self._newest = 0
        self._makers: tuple[Callable[[Seen], Mutant], ...] = (
            self._rubbish,
            self._cut,
            self._flipped,
            self._replayed,
            self._of_another_cycle,
            self._of_another_time,
            self._of_another_vehicle,
            self._on_a_foreign_key,
            self._on_another_stream,
            self._in_parts,
            self._deleted,
        )

    def see(self, seen: Seen) -> None:
        """Learn a real message."""
        self._seen.append(seen)
        self._newest = max(self._newest, seen.cycle)

    def mutants(self, count: int) -> Iterator[Mutant]:
        """Yield `count` mutants of all kinds in turn."""
        for number in range(count if self._seen else 0):
            maker = self._makers[number % len(self._makers)]
            yield maker(self._random.choice(self._seen))

    def _key(self, seen: Seen) -> str:
        return seen.topic.key(self._run, seen.vehicle)

    def _old(self, seen: Seen) -> Seen:
        """Return a message whose cycle is over for every reader: `seen`, or the oldest."""
        return seen if seen.cycle < self._newest - WINDOW else self._seen[0]

    def _rubbish(self, seen: Seen) -> Mutant:
        return Mutant(self._key(seen), self._random.randbytes(self._random.randrange(1, 200)))

    def _cut(self, seen: Seen) -> Mutant:
        seen = self._old(seen)
        length = self._random.randrange(1, max(2, len(seen.payload)))
        return Mutant(self._key(seen), seen.payload[:length])

    def _flipped(self, seen: Seen) -> Mutant:
        seen = self._old(seen)
        while True:
            payload = bytearray(seen.payload)
            for _ in range(self._random.randrange(1, 8)):
                payload[self._random.randrange(len(payload))] ^= 1 << self._random.randrange(8)
            if not _arrives_at_another_time(seen, bytes(payload)):
                return Mutant(self._key(seen), bytes(payload))

    def _replayed(self, seen: Seen) -> Mutant:
        """Replay a message, even one of the present cycle."""
        return Mutant(self._key(seen), seen.payload)

    def _of_another_cycle(self, seen: Seen) -> Mutant:
        message = self._marked(seen)
        steps = [*range(-20, 0), *range(1, 20), 100, 10**9]
        message.cycle = min(max(0, seen.cycle + self._random.choice(steps)), 2**32 - 1)
        if message.cycle == seen.cycle:
            message.cycle = 2**32 - 1
        return Mutant(self._key(seen), message.SerializeToString())

    def _of_another_time(self, seen: Seen) -> Mutant:
        message = self._marked(seen)
        steps = (-(10**8), 1, 10**6, 10**8, 10**15)
        times = [*(message.time_ns + step for step in steps), -(2**63), 2**63 - 1]
        message.time_ns = self._random.choice(times)
        message.cycle = self._newest + self._random.randrange(4)
        if message.time_ns // 10**8 == message.cycle:
            message.time_ns = -1
        return Mutant(self._key(seen), message.SerializeToString())

    def _of_another_vehicle(self, seen: Seen) -> Mutant:
        """Send a vehicle's message, with its cycle and time, as that of another vehicle."""
        if not seen.topic.per_vehicle:
            return self._on_a_foreign_key(seen)
        other = seen.vehicle % self._size + 1
        return Mutant(seen.topic.key(self._run, other), seen.payload)

    def _on_a_foreign_key(self, seen: Seen) -> Mutant:
        own = self._key(seen)
        strangers = [f"vehicle/{who}/{what}" for who in (0, 99, "x", "٣") for what in _NAMES]
        keys = ["**", "*/*/**", *(f"zenvoy/{self._run}/{end}" for end in (*strangers, "**"))]
        keys += [own.rpartition("/")[0] + "/*", f"zenvoy/*/{own.split('/', 2)[2]}"]
        return Mutant(self._random.choice(keys), seen.payload)

    def _on_another_stream(self, seen: Seen) -> Mutant:
        other = self._random.choice([topic for topic in READ if topic is not seen.topic])
        return Mutant(other.key(self._run, seen.vehicle or 1), seen.payload)

    def _in_parts(self, seen: Seen) -> Mutant:
        attachment = self._random.randbytes(self._random.choice((3, 12, 12, 12)))
        if self._random.random() < 0.5:  # one part without all the others
            attachment = b"\0\0\0\0" + b"\2\0\0\0" + attachment[-3:] + b"\0"
        return Mutant(self._key(seen), seen.payload, attachment)

    def _deleted(self, seen: Seen) -> Mutant:
        return Mutant(self._key(seen), None)

    def _marked(self, seen: Seen) -> Any:
        message = seen.topic.decode(seen.payload)
        if hasattr(message, "acceleration"):
            message.acceleration = self._random.choice((MARK, float("nan"), 1e308))
        return message


_NAMES: Final = ("sense", "beacon", "receive", "command")


def _arrives_at_another_time(seen: Seen, payload: bytes) -> bool:
    """Return whether flips change both times of a receive alike, which makes a valid frame."""
    if seen.topic is not RECEIVE:
        return False
    try:
        message = pb.Receive.FromString(payload)
    except DecodeError:
        return False
    real = pb.Receive.FromString(seen.payload)
    last_ns = max(message.arrived_ns, default=message.time_ns)
    return message.time_ns != real.time_ns and last_ns == message.time_ns


class Bundler:
    """Takes real bundles of shared processes apart, and puts mutants into such bundles."""

    def __init__(self, run: str, shared: Sequence[VehicleProcess], seed: int) -> None:
        self._random = random.Random(seed)
        self._topics = {
            topic.shared_key(run, process.name): topic
            for process in shared
            for topic in READ
            if topic.per_vehicle
        }
        self._places = {
            topic.key(run, vehicle): (topic.shared_key(run, process.name), process, vehicle)
            for process in shared
            for vehicle in process.vehicles
            for topic in READ
            if topic.per_vehicle
        }

    def seen(self, key: str, payload: bytes) -> list[Seen]:
        """Return the real messages of a bundle."""
        topic = self._topics.get(key)
        if topic is None:
            return []
        return [
            Seen(topic, vehicle, one, topic.decode(one).cycle) for vehicle, one in unpack(payload)
        ]

    def bundled(self, mutant: Mutant) -> Mutant:
        """Return the mutant in a bundle, a mutant of the bundle, or the mutant as it is."""
        key, payload, attachment = mutant
        if key not in self._places or payload is None:
            return mutant
        shared, process, vehicle = self._places[key]
        stranger = self._random.choice([0, max(process.vehicles) + 1, 2**32 - 1])
        bundle = pack([(vehicle, payload)])
        twice = pack([(vehicle, payload), (vehicle, payload)])
        made = self._random.choice(
            [bundle] * 6
            + [
                twice,
                pack([(vehicle, payload), (stranger, payload)]),
                pack([(vehicle, payload), (process.vehicles[0], b"")]),
                bundle[: self._random.randrange(len(bundle))],
                pb.Bundle(vehicle=process.vehicles, payload=[payload]).SerializeToString(),
                b"",
            ]
        )
        return mutant if self._random.random() < 0.2 else Mutant(shared, made, attachment)


class Turns:
    """The world announces its cycle, and in lock-step waits until the attacker is done.

    So every cycle has the same number of mutants, however busy the machine is. The mutants of two
    cycles must fit in a queue of the world, which reads none while it waits here.
    """

    def __init__(self, *, realtime: bool) -> None:
        self._realtime = realtime
        self._cycles, self._answers = os.pipe(), os.pipe()

    def take(self, clock: pb.Clock) -> None:
        """Announce the cycle, and wait. The world calls this."""
        os.write(self._cycles[1], clock.cycle.to_bytes(_BYTES))
        if not self._realtime:
            os.read(self._answers[0], 1)

    def next(self) -> int:
        """Return the next cycle as soon as it has begun. The attacker calls this."""
        return int.from_bytes(os.read(self._cycles[0], _BYTES))

    def done(self) -> None:
        """Let the world go on. The attacker calls this."""
        os.write(self._answers[1], b"\0")


_BYTES: Final = 4


def attack(
    run: str,
    size: int,
    shared: Sequence[VehicleProcess],
    links: tuple[str, list[str]],
    per_cycle: int,
    realtime: bool,
    turns: Turns,
) -> None:
    """Send `per_cycle` mutants in each cycle from FIRST_CYCLE on.

    `links` are the endpoint to listen on and those to connect to. The attacker always reads its
    messages, since a reader that does not read stops a run in lock-step.
    """
    listen, connect = links
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM,))
    with open_session([listen], connect, realtime=realtime) as session:
        topics = streams(run, size)
        mutator, bundler = Mutator(run, size, seed=1), Bundler(run, shared, seed=1)
        while turns.next() < 2:
            turns.done()  # a subscriber that comes before the real reader would be taken for it
        heard = session.declare_subscriber(
            f"zenvoy/{run}/**", zenoh.handlers.RingChannel(1_000), allowed_origin=_OTHERS
        )
        drop = zenoh.CongestionControl.DROP if realtime else zenoh.CongestionControl.BLOCK
        while True:
            turns.done()
            cycle = turns.next()
            while (sample := heard.try_recv()) is not None:
                key, payload = str(sample.key_expr), sample.payload.to_bytes()
                of = topics.get(key)
                if of is not None and sample.attachment is None:
                    mutator.see(Seen(*of, payload, of[0].decode(payload).cycle))
                for seen in bundler.seen(key, payload):
                    mutator.see(seen)
            if cycle < FIRST_CYCLE:
                continue
            for mutant in mutator.mutants(per_cycle):
                key, made, attachment = bundler.bundled(mutant)
                if made is None:
                    session.delete(key, congestion_control=drop)
                else:
                    session.put(key, made, attachment=attachment, congestion_control=drop)


_OTHERS: Final = zenoh.Locality.REMOTE


def main(scenario: Path, out: Path, per_cycle: int, per_process: int) -> list[Death]:
    """Run the scenario under attack, and return the deaths of processes."""
    loaded = load(scenario)
    folder = make_folder(out, loaded.name)
    labels = labels_of(loaded, "zenoh", per_process)
    deaths: list[Death] = []
    realtime = loaded.scenario.clock == "realtime"
    turns = Turns(realtime=realtime)
    with tempfile.TemporaryDirectory(prefix="zt-") as sockets:
        met = endpoints_of(labels.run, Path(sockets), ())
        table = process_table(
            loaded.scenario,
            labels,
            folder / "run.mcap",
            Path(sockets),
            turns.take,
            met,
            per_process=per_process,
        )
        here = f"unixsock-stream/{sockets}/attacker"
        size = loaded.scenario.fleet.size
        shared = [process for process in vehicle_processes(size, per_process) if process.is_shared]
        links = here, list(met.connect)
        attacker = Program(
            name="attacker",
            run=labels.run,
            main=partial(attack, labels.run, size, shared, links, per_cycle, realtime, turns),
            essential=False,
        )
        programs = [*(_within_reach(program, here) for program in table), attacker]
        read_fd, write_fd = os.pipe()
        with Supervisor(programs, folder / "logs", loaded.scenario.stall_limit_s) as supervisor:
            death = supervisor.watch(read_fd, lambda _: None, deaths.append)
        os.close(read_fd)
        os.close(write_fd)
    return deaths if death is None else [*deaths, death]


def _within_reach(program: Program, attacker: str) -> Program:
    """Return the program, with a link to the attacker if it is a vehicle's."""
    main = program.main
    assert isinstance(main, partial)
    if main.func not in {run_vehicle, run_vehicles}:
        return program
    scenario, which, wiring = main.args
    linked = replace(wiring, connect=(*wiring.connect, attacker))
    return replace(program, main=partial(main.func, scenario, which, linked))


if __name__ == "__main__":
    ended = main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
    for one in ended:
        print(one, *one.tail, sep="\n", file=sys.stderr)
    sys.exit(bool(ended))
