"""Where the page of a run is served: on loopback alone."""

from __future__ import annotations

import errno
import socket
from typing import Final

ADDRESS: Final = "127.0.0.1"
PORT: Final = 8600
"""The port where a browser may look first."""


class PortError(Exception):
    """A port cannot be listened on."""


def listener(port: int | None) -> socket.socket:
    """Return a socket that listens on loopback; raises PortError.

    For None it takes the usual port, or any free one if that is taken.
    """
    made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((ADDRESS, PORT if port is None else port))
    except OSError as error:
        if port is not None or error.errno not in {errno.EADDRINUSE, errno.EACCES}:
            made.close()
            raise PortError(f"port {port}: {error.strerror}") from error
        made.bind((ADDRESS, 0))
    made.listen(128)
    made.setblocking(False)
    return made


def address_of(made: socket.socket) -> str:
    """Return the address of the page."""
    return f"http://{ADDRESS}:{made.getsockname()[1]}/"
