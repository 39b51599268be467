"""Vehicles that a run leaves to other programs: which, and where these connect to."""

from __future__ import annotations

import json
import socket
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

FILE: Final = "connect.json"


class GuestsError(Exception):
    """What is asked for guests cannot be; the text says why in a line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Guests:
    """The vehicles that a run starts without, and endpoints beside the Unix sockets.

    The world listens at each `tcp/<host>:<port>` of `listen`, the channel at the next port.
    """

    without: frozenset[int] = frozenset()
    listen: tuple[str, ...] = ()


NO_GUESTS: Final = Guests()


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """Where a run is met: its name, and the endpoints of its world and of its channel."""

    run: str
    world: tuple[str, ...]
    channel: tuple[str, ...]

    def write(self, folder: Path) -> None:
        """Leave it in the folder of the run."""
        (folder / FILE).write_text(json.dumps(asdict(self), indent=2) + "\n", encoding="utf-8")

    @property
    def connect(self) -> tuple[str, ...]:
        """The nearest endpoint of each."""
        return self.world[0], self.channel[0]


def guests(without: Sequence[int], listen: Sequence[str], size: int) -> Guests:
    """What was asked for, if it can be in a fleet of `size`; raises GuestsError."""
    for vehicle in without:
        if not 1 <= vehicle <= size:
            raise GuestsError(
                f"--without {vehicle}: is not in [1, {size}], the vehicles of fleet.size ({size})"
            )
    for endpoint in listen:
        host, port = _address(endpoint)
        for number in (port, port + 1):
            try:
                with socket.create_server((host, number), family=_family(host)):
                    pass
            except OSError as error:
                why = error.strerror or str(error)
                raise GuestsError(f"--listen {endpoint}: port {number}: {why}") from error
    return Guests(without=frozenset(without), listen=tuple(listen))


def meeting(run: str, sockets: Path, listen: Sequence[str]) -> Meeting:
    """Where a run listens: on Unix sockets in a folder of its own, and where it was asked to."""
    beside = [_address(endpoint) for endpoint in listen]
    return Meeting(
        run=run,
        world=(f"unixsock-stream/{sockets / 'world'}", *listen),
        channel=(
            f"unixsock-stream/{sockets / 'channel'}",
            *(f"tcp/{_bracketed(host)}:{port + 1}" for host, port in beside),
        ),
    )


def read_meeting(folder: Path) -> Meeting:
    """What a run under way has left in its folder; raises GuestsError."""
    path = folder / FILE
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        return Meeting(run=told["run"], world=tuple(told["world"]), channel=tuple(told["channel"]))
    except OSError as error:
        raise GuestsError(
            f"--run {folder}: has no {FILE}; name the folder of a run under way, or say --connect"
        ) from error
    except (ValueError, KeyError, TypeError) as error:
        raise GuestsError(f"--run {folder}: {FILE} does not say where to connect to") from error


def _address(endpoint: str) -> tuple[str, int]:
    """Host and port of a TCP endpoint; raises GuestsError."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if protocol != "tcp" or not host or not port.isdecimal() or not 1 <= int(port) < 65_535:
        raise GuestsError(
            f"--listen {endpoint}: is not tcp/<host>:<port> with a port in [1, 65534]"
        )
    return host, int(port)


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET
