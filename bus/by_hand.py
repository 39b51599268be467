"""Requests of a person to a run in real time, from the page that shows it to the world."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from contextlib import suppress
from typing import Final, NamedTuple

_FORM: Final = struct.Struct("<Bd")
_BRAKE, _LOSE = range(2)


class Brake(NamedTuple):
    """A vehicle is to brake."""

    vehicle: int


class Lose(NamedTuple):
    """A share of all frames, 0 to 1, is to be lost besides those that the scenario loses."""

    share: float


def pair() -> tuple[socket.socket, socket.socket]:
    """Return the two ends, of which neither ever blocks: one asks, the other is asked."""
    ends = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    for end in ends:
        end.setblocking(False)
    return ends


def ask(end: socket.socket, request: Brake | Lose) -> bool:
    """Send a request; return whether it is on its way."""
    try:
        end.send(_FORM.pack(_BRAKE if isinstance(request, Brake) else _LOSE, *request))
    except OSError:  # the world has ended, or has not answered for long
        return False
    return True


def asked(end: socket.socket) -> Iterator[Brake | Lose]:
    """Yield the requests that have come."""
    with suppress(OSError):
        while data := end.recv(_FORM.size):
            kind, value = _FORM.unpack(data)
            yield Brake(int(value)) if kind == _BRAKE else Lose(value)
