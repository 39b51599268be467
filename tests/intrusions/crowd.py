"""A crowd at the doors: connections that do nothing, a reader that never reads, large messages."""

from __future__ import annotations

import socket
import ssl
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

import zenoh

_IDLE: Final = 5  # connections of each kind at each door
_LARGE_MESSAGES: Final = 20


class Crowd:
    """Those who take up room at the doors of a run.

    `never_reads` is a session and the key that it subscribes to; `sends` a session and the key on
    which it sends large messages.
    """

    def __init__(
        self,
        *,
        doors: Sequence[str],
        never_reads: tuple[zenoh.Session, str],
        sends: tuple[zenoh.Session, str],
    ) -> None:
        self._doors = [address_of(door) for door in doors]
        self._never_reads, self._sends = never_reads, sends
        self._kept: list[object] = []

    def come(self) -> None:
        """Connect and say nothing; shake hands without a certificate; subscribe and never read."""
        for door in self._doors:
            for _ in range(_IDLE):
                self._kept.append(socket.create_connection(door, timeout=60))
        session, key = self._never_reads
        # The queue takes one message. Then Zenoh waits, and reads no more from its link.
        self._kept.append(session.declare_subscriber(key, zenoh.handlers.FifoChannel(1)))

    def send(self, size: int) -> None:
        """Send large messages."""
        session, key = self._sends
        for _ in range(_LARGE_MESSAGES):
            session.put(key, bytes(size), congestion_control=zenoh.CongestionControl.DROP)


def knock(door: tuple[str, int], times: int) -> int:
    """Connect and shake hands without a certificate, one after the other; return how many reached.

    A connection counts when the listener has accepted it in its queue, whatever it does then.
    """
    reached = 0
    unchecked = ssl.create_default_context()
    unchecked.check_hostname, unchecked.verify_mode = False, ssl.CERT_NONE
    for _ in range(times):
        with suppress(OSError), socket.create_connection(door, timeout=0.5) as raw:
            reached += 1
            raw.settimeout(0.02)
            with unchecked.wrap_socket(raw, do_handshake_on_connect=False) as secured:
                secured.do_handshake()
    return reached


def address_of(endpoint: str) -> tuple[str, int]:
    """Return the host and the port of an endpoint."""
    host, port = endpoint.partition("/")[2].rsplit(":", 1)
    return host, int(port)
