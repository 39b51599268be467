"""Attempts to get into a run, or to do there what a certificate does not allow.

`python -m tests.intrusions FOLDER RUN WORLD CHANNEL` makes all attempts, or those that concern a
router if it is both doors. It prints what came of them as a line of JSON, and stays until its input
ends. Then it prints what it has heard, once the observer has heard the clock, as it may.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import traceback
from pathlib import Path
from typing import Final

import zenoh

from tests.conftest import LIMIT_S
from tests.fleet.joining import free_ports
from tests.intrusions.crowd import Crowd, address_of
from tests.intrusions.intruder import answers, enter, member
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.doors import Doors
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import (
    BEACON,
    CLOCK,
    COMMAND,
    LINKS,
    POSITIONS,
    SENSE,
    TRUTH,
    alive_key,
    processes_key,
    scenario_key,
)
from zenvoy.fleet.certificates import doors_of

MILLION: Final = 1_000_000
_WAITS: Final = zenoh.CongestionControl.BLOCK  # where Zenoh would drop messages on a busy machine
# How somebody without a valid certificate tries to come in: the folder and the certificate.
STRANGERS: Final = {
    "no certificate": ("keys", ""),
    "no TLS": (None, ""),
    "another authority": ("others", "vehicle-3"),
    "another authority's world": ("others", "world"),
    "expired": ("expired", "vehicle-3"),
    "not yet valid": ("early", "vehicle-3"),
}


class Attempts:
    """All attempts on one run, and what came of them.

    `failed` has, by attempt, whether it failed as far as the intruder can tell. `heard` has the
    keys of all messages that came, by the attempt to read them. `clock_came` is set once one came
    to the observer, which may be after the run.
    """

    def __init__(self, folder: Path, run: str, world: str, channel: str) -> None:
        self._folder, self._run = folder, run
        self._world, self._channel = world, channel
        self._kept: list[object] = []
        self.failed: dict[str, bool] = {}
        self.heard: dict[str, list[str]] = {}
        self.clock_came = threading.Event()

    def make(self) -> None:
        """Make all attempts."""
        self._strangers()
        self._impostor()
        self._nobodies()
        keys = self._folder / "keys"
        for role, door in (("world", self._world), ("channel", self._channel)):
            three = member(door, keys, "vehicle-3")
            self._kept.append(three)
            self._as_vehicle(role, three)
        observer = member(self._world, keys, "observer")
        self._kept.append(observer)
        self._as_observer(observer)
        self._as_servers(keys)

    def _strangers(self) -> None:
        for what, (where, name) in STRANGERS.items():
            door = self._world if where else self._world.replace("tls/", "tcp/")
            session = enter(door, None if where is None else self._folder / where, name)
            self.failed[what] = session is None

    def _impostor(self) -> None:
        """Serve as a world with the certificate of a vehicle, and wait for a vehicle."""
        keys = self._folder / "keys"
        identity = doors_of(keys, "vehicle-3").identity
        host, _ = address_of(self._channel)
        endpoint = f"tls/{host}:{free_ports()[0]}"
        with open_session([endpoint], [], doors=Doors(identity=identity)):
            self.failed["serves as a world"] = enter(endpoint, keys, "vehicle-2") is None

    def _nobodies(self) -> None:
        """Come in with a certificate of the authority that has no line in the list."""
        who = {"revoked": ("keys", "vehicle-1"), "never listed": ("unlisted", "vehicle-3")}
        for what, (where, name) in who.items():
            session = member(self._world, self._folder / where, name)
            self._kept.append(session)
            asked = answers(session, scenario_key(self._run))
            self.failed[f"{what}: asks for the scenario"] = not asked
            self._put(session, COMMAND.key(self._run, 1), _command(1))
            self._listen(f"{what}: reads the clock", session, CLOCK.key(self._run))

    def _as_vehicle(self, role: str, three: zenoh.Session) -> None:
        """Do with the certificate of vehicle 3 what only others may."""
        run = self._run
        assert role != "world" or answers(three, scenario_key(run), 60.0)  # it may ask for that
        for key, payload in (
            (COMMAND.key(run, 1), _command(1)),
            (COMMAND.key(run, "*"), _command(1)),
            (COMMAND.shared_key(run, "vehicles-01-04"), _command(1)),
            (BEACON.key(run, 1), _beacon(1)),
            (SENSE.key(run, 1), pb.Sense(cycle=0, vehicle=1).SerializeToString()),
            (POSITIONS.key(run), pb.Positions(cycle=0).SerializeToString()),
            (LINKS.key(run), pb.Links(cycle=0).SerializeToString()),
        ):
            self._put(three, key, payload)
        three.delete(COMMAND.key(run, 1))
        self._listen(f"{role}: reads another's senses", three, SENSE.key(run, 1))
        self._listen(f"{role}: reads all senses", three, SENSE.keys(run))
        self._listen(f"{role}: reads everything", three, f"zenvoy/{run}/**")
        found = three.liveliness().get(alive_key(run), timeout=3)
        self.failed[f"{role}: asks who is there"] = not [one for one in found if one.ok]
        asked = answers(three, "zenvoy/*/scenario")
        self.failed[f"{role}: asks for any scenario"] = not asked
        for name in ("vehicle-02", "channel"):  # from here on, its session knows tokens of its own
            self._kept.append(three.liveliness().declare_token(alive_key(run, name)))
        self._kept.append(three.declare_queryable(scenario_key(run), _answer_nonsense))

    def _as_observer(self, observer: zenoh.Session) -> None:
        """Do more than look on, and look on."""
        run = self._run
        for what, key in (("the scenario", scenario_key(run)), ("who runs", processes_key(run))):
            self.failed[f"observer: asks for {what}"] = not answers(observer, key)
        self._put(observer, COMMAND.key(run, 1), _command(1))
        self._put(observer, CLOCK.key(run), pb.Clock(cycle=7).SerializeToString())
        self._listen("observer: reads commands", observer, COMMAND.key(run, 1))
        self._listen("observer: reads a truth that is not public", observer, TRUTH.key(run))
        self._listen("observer: reads the clock", observer, CLOCK.key(run), self.clock_came)

    def _as_servers(self, keys: Path) -> None:
        """Do with the channel's certificate what only a vehicle may, and so on."""
        channel = member(self._world, keys, "channel")
        self._put(channel, COMMAND.key(self._run, 1), _command(1))
        world = member(self._channel, keys, "world")
        self._put(world, BEACON.key(self._run, 1), _beacon(1))
        self._kept += [channel, world]

    def at_router(self) -> None:
        """Make the attempts that concern a router, which is both doors of the run."""
        keys = self._folder / "keys"
        self._strangers()
        self._nobodies()
        three = member(self._world, keys, "vehicle-3")
        observer = member(self._world, keys, "observer")
        self._kept += [three, observer]
        self._as_vehicle("router", three)
        self._as_observer(observer)
        self._as_servers(keys)
        for mode in ("peer", "router"):  # a router tells others of its kind what it routes
            session = member(self._world, keys, "vehicle-3", mode=mode)
            self._kept.append(session)
            self._put(session, COMMAND.key(self._run, 4), _command(4))
            self._listen(f"as a {mode}: reads everything", session, f"zenvoy/{self._run}/**")
            asked = answers(session, "zenvoy/*/scenario")
            self.failed[f"as a {mode}: asks for any scenario"] = not asked

    def _put(self, session: zenoh.Session, key: str, payload: bytes) -> None:
        """Put a message, and so again with a publisher, to whose key Zenoh gives a number."""
        session.put(key, payload, congestion_control=_WAITS)
        if "*" not in key:
            publisher = session.declare_publisher(key, congestion_control=_WAITS)
            publisher.put(payload)
            self._kept.append(publisher)

    def _listen(
        self, what: str, session: zenoh.Session, key: str, came: threading.Event | None = None
    ) -> None:
        heard = self.heard[what] = []

        def note(sample: zenoh.Sample) -> None:
            heard.append(str(sample.key_expr))
            if came is not None:
                came.set()

        others = zenoh.Locality.REMOTE
        self._kept.append(session.declare_subscriber(key, note, allowed_origin=others))

    def crowd(self) -> Crowd:
        """Return those who only take up room, with sessions of their own."""
        keys = self._folder / "keys"
        reader = member(self._world, keys, "observer")
        return Crowd(
            doors=(self._world, self._channel),
            never_reads=(reader, CLOCK.key(self._run)),
            sends=(member(self._world, keys, "vehicle-3"), COMMAND.key(self._run, 3)),
        )


def _answer_nonsense(query: zenoh.Query) -> None:
    with query:
        query.reply(query.key_expr, b"{}")


def _command(vehicle: int) -> bytes:
    return pb.Command(
        cycle=0,
        time_ns=50_000_000,
        vehicle=vehicle,
        effective_ns=110_000_000,
        acceleration=-3.0,
        mode=pb.MODE_FM,
    ).SerializeToString()


def _beacon(vehicle: int) -> bytes:
    return pb.Beacon(cycle=0, vehicle=vehicle, position=1.0, speed=2.0).SerializeToString()


def main(folder: str, run: str, world: str, channel: str) -> None:
    """Make the attempts, and tell what came of them."""
    attempts = Attempts(Path(folder), run, world, channel)
    if world == channel:
        attempts.at_router()
    else:
        attempts.make()
    crowd = attempts.crowd()
    crowd.come()
    print(json.dumps(attempts.failed), flush=True)
    for line in sys.stdin:
        if line == "send\n":
            crowd.send(MILLION)
    attempts.clock_came.wait(LIMIT_S)
    print(json.dumps(attempts.heard), flush=True)
    os._exit(0)  # closing the sessions may wait for a run that has ended


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    finally:  # only an error comes here, as `main` exits; open sessions would keep Python alive
        traceback.print_exc()
        os._exit(1)
