"""What a session needs to let in only those who belong: certificates, access control, limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from zenvoy.bus.parts import MAX_PAYLOAD_BYTES

# A message is its payload with an attachment of a few bytes. A larger one is dropped on arrival.
_MAX_MESSAGE_BYTES: Final = MAX_PAYLOAD_BYTES + 8_192


@dataclass(frozen=True, slots=True, kw_only=True)
class Identity:
    """The files that prove who a process is: certificates of the authority and its own, its key."""

    authority: Path
    certificate: Path
    key: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Doors:
    """The TLS of a session: who this process is, and for a listener who may do what."""

    identity: Identity
    access: Mapping[str, object] = field(default_factory=dict[str, object])

    def guarded(self, access: Mapping[str, object]) -> Doors:
        """Return these doors with access control."""
        return replace(self, access=access)

    @property
    def settings(self) -> dict[str, object]:
        """The settings of Zenoh, by path.

        A listener uses the default transport, with any clock: a low-latency link would block it
        when its reader does not read.
        """
        certificate, key = str(self.identity.certificate), str(self.identity.key)
        tls = {
            "root_ca_certificate": str(self.identity.authority),
            "enable_mtls": True,
            "listen_certificate": certificate,
            "listen_private_key": key,
            "connect_certificate": certificate,
            "connect_private_key": key,
            "verify_name_on_connect": True,
            "close_link_on_expiration": True,
        }
        found: dict[str, object] = {"transport/link/tls": tls}
        if self.access:
            found |= {
                "access_control": dict(self.access),
                "transport/unicast/lowlatency": False,
                "transport/link/rx/max_message_size": _MAX_MESSAGE_BYTES,
            }
        return found
