"""The names and addresses of this machine."""

from __future__ import annotations

import socket
from typing import Final

# An address for documentation (RFC 5737): nothing is sent to it.
_FAR_AWAY: Final = ("192.0.2.1", 9)


def hosts_here() -> list[str]:
    """Return the names and addresses by which others may reach this machine, loopback first."""
    found = ["localhost", "127.0.0.1", "::1", socket.gethostname()]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_FAR_AWAY)  # chooses the address of the interface to the outside
            found.append(probe.getsockname()[0])
        except OSError:  # no network
            pass
    return list(dict.fromkeys(found))
