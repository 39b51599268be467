"""Declares every message stream once. Keys are built only here."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

from google.protobuf.message import DecodeError, Message

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.errors import PayloadError

_PLAIN: Final = re.compile(r"[\w.-]{1,100}", re.ASCII)

OBSERVER: Final = "observer"
"""The role of a program that only looks on, such as a recorder. Nobody waits for one."""

M_co = TypeVar("M_co", bound=Message, covariant=True)


@dataclass(frozen=True, slots=True, eq=False)
class Topic(Generic[M_co]):
    """A stream: its key, its message type, its writer and reader, its name in the log."""

    name: str
    message: type[M_co]
    pattern: str | None = None  # of its key; None if it does not leave the world process
    writer: str = "world"
    reader: str | None = None  # the role that reads it; None if any program may read it
    logged_as: str | None = None

    @property
    def log_name(self) -> str:
        """The name of this stream in the log; raises ValueError if it is not logged."""
        if self.logged_as is None:
            raise ValueError(f"{self.name} is not logged")
        return self.logged_as

    def key(self, run: str, vehicle: int | str = "*") -> str:
        """Return the Zenoh key of this stream in `run`; `*` stands for all vehicles."""
        if self.pattern is None:
            raise ValueError(f"{self.name} has no key")
        return f"zenvoy/{run}/{self.pattern.format(id=vehicle)}"

    def shared_key(self, run: str, process: str) -> str:
        """Return the Zenoh key of a process for the streams of its vehicles, in `pb.Bundle`s."""
        if not self.per_vehicle:
            raise ValueError(f"{self.name} is not a stream of vehicles")
        return f"zenvoy/{run}/process/{process}/{self.name}"

    def keys(self, run: str) -> str:
        """Return the key expression of this stream for all vehicles, in any processes."""
        return f"zenvoy/{run}/*/*/{self.name}" if self.per_vehicle else self.key(run)

    @property
    def is_awaited(self) -> bool:
        """Whether its writer waits for a reader, and must not lose a message."""
        return self.reader not in (None, OBSERVER)

    def is_open(self, public: Collection[str]) -> bool:
        """Whether it is published, if those streams for observers are whose names are `public`."""
        return self.pattern is not None and (self.reader != OBSERVER or self.name in public)

    @property
    def per_vehicle(self) -> bool:
        """Whether each vehicle has a stream of its own."""
        return self.pattern is not None and "{id}" in self.pattern

    def decode(self, payload: bytes) -> M_co:
        """Return the message in `payload`; raises PayloadError if there is none."""
        try:
            return self.message.FromString(payload)
        except DecodeError as error:
            raise PayloadError(f"{self.name}: not a {self.message.__name__}: {error}") from error


SENSE: Final = Topic("sense", pb.Sense, "vehicle/{id}/sense", reader="vehicle")
BEACON: Final = Topic(
    "beacon", pb.Beacon, "vehicle/{id}/beacon", writer="vehicle", reader="channel"
)
RECEIVE: Final = Topic(
    "receive", pb.Receive, "vehicle/{id}/receive", writer="channel", reader="vehicle"
)
COMMAND: Final = Topic(
    "command", pb.Command, "vehicle/{id}/command", writer="vehicle", reader="world"
)
POSITIONS: Final = Topic("positions", pb.Positions, "channel/positions", reader="channel")
LINKS: Final = Topic("links", pb.Links, "channel/links", writer="channel", reader="world")
CLOCK: Final = Topic("clock", pb.Clock, "clock", logged_as="/clock")

TRUTH: Final = Topic("truth", pb.FleetTruth, "truth", reader=OBSERVER, logged_as="/fleet/truth")
RADAR: Final = Topic("radar", pb.FleetRadar, logged_as="/fleet/radar")
ESTIMATE: Final = Topic("estimate", pb.FleetEstimate, logged_as="/fleet/estimate")
FLEET_COMMAND: Final = Topic("fleet command", pb.FleetCommand, logged_as="/fleet/command")
FRAMES: Final = Topic("frames", pb.Frames, logged_as="/v2v/frames")
EVENTS: Final = Topic("events", pb.Event, logged_as="/events")
REALTIME: Final = Topic("realtime", pb.RealTime, logged_as="/realtime")

TOPICS: Final = (
    SENSE,
    BEACON,
    RECEIVE,
    COMMAND,
    POSITIONS,
    LINKS,
    CLOCK,
    TRUTH,
    RADAR,
    ESTIMATE,
    FLEET_COMMAND,
    FRAMES,
    EVENTS,
    REALTIME,
)
LOGGED: Final = tuple(
    topic for topic in TOPICS if topic.logged_as is not None and topic is not REALTIME
)
"""Topics of every log; only logs of real time also have REALTIME."""


def is_plain(name: str) -> bool:
    """Return whether a name can be part of keys, and be shown as it is."""
    return _PLAIN.fullmatch(name) is not None


def plain_name(name: str) -> str:
    """Return the name of a run if it can be part of keys; raises ValueError for any other.

    In Zenoh `*` and `$*` are wildcards, `/` is a separator, and `#`, `?` and `@` are special too.
    """
    if not is_plain(name):
        raise ValueError(
            f"{name[:80]!r} cannot be the name of a run; allowed: up to 100 of a-z, A-Z, 0-9, "
            ". _ and -"
        )
    return name


def vehicle_name(vehicle: int, size: int) -> str:
    """Return the name of a vehicle's process, padded so that names sort: `vehicle-07` of 40."""
    return f"vehicle-{vehicle:0{max(2, len(str(size)))}d}"


def alive_key(run: str, process: str = "*") -> str:
    """Return the key of a process's liveliness token."""
    return f"zenvoy/{run}/alive/{process}"


def host_key(run: str, process: str = "*", host: str = "*") -> str:
    """Return the key of a token that says on which other machine a process runs."""
    return f"zenvoy/{run}/on/{process}/{host}"


def processes_key(run: str) -> str:
    """Return the key of the queryable for the processes of the run, as JSON."""
    return f"zenvoy/{run}/processes"


def time_key(run: str) -> str:
    """Return the key of the queryable for the time on the clock of the world's machine, ns."""
    return f"zenvoy/{run}/time"


def scenario_key(run: str) -> str:
    """Return the key of the queryable for the effective scenario, as JSON."""
    return f"zenvoy/{run}/scenario"


def about_key(run: str = "*") -> str:
    """Return the key of the queryable by which programs find the runs there are."""
    return f"zenvoy/{run}/about"
