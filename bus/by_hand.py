"""Requests of a person to a run in real time, from the page that shows it to the world."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import suppress


def pair() -> tuple[socket.socket, socket.socket]:
    """Return the two ends, of which neither ever blocks: one asks, the other is asked."""
    ends = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    for end in ends:
        end.setblocking(False)
    return ends


def ask_to_brake(end: socket.socket, vehicle: int) -> bool:
    """Ask that a vehicle brake; return whether the request is on its way."""
    try:
        end.send(vehicle.to_bytes(4, "little"))
    except OSError:  # the world has ended, or has not answered for long
        return False
    return True


def asked_to_brake(end: socket.socket) -> Iterator[int]:
    """Yield the vehicles that are asked to brake."""
    with suppress(OSError):
        while data := end.recv(4):
            yield int.from_bytes(data, "little")
