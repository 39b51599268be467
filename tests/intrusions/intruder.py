"""A session of an intruder, at one door of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

import zenoh

_PATIENCE_S: Final = 3.0
_LEGITIMATE_S: Final = 60.0


def enter(
    endpoint: str,
    keys: Path | None,
    name: str = "",
    limit_s: float = _PATIENCE_S,
    *,
    mode: str = "client",
) -> object:
    """Return an open session as a client of an endpoint, or None if it is not let in.

    `keys` and `name` choose the certificate; without a name the client has none. It trusts the
    run's own authority, in the folder `keys` beside that of its certificate.
    """
    tls: dict[str, object] = {"verify_name_on_connect": False}
    if keys is not None:
        tls["root_ca_certificate"] = str(keys.parent / "keys" / "authority.pem")
    if name and keys is not None:
        tls |= {
            "enable_mtls": True,
            "connect_certificate": str(keys / f"{name}.pem"),
            "connect_private_key": str(keys / f"{name}.key"),
        }
    settings: dict[str, object] = {
        "mode": mode,
        "listen/endpoints": [],
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": round(limit_s * 1_000),
        "scouting/multicast/enabled": False,
        "transport/shared_memory/enabled": False,
    }
    if endpoint.startswith("tls/"):
        settings["transport/link/tls"] = tls
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    try:
        return zenoh.open(config)
    except zenoh.ZError:
        return None


def member(endpoint: str, keys: Path, name: str, *, mode: str = "client") -> zenoh.Session:
    """Return the session of one whose certificate is in order; an error says that it is not."""
    session = enter(endpoint, keys, name, _LEGITIMATE_S, mode=mode)
    assert isinstance(session, zenoh.Session), f"{name} is not let in at {endpoint}"
    return session


def answers(session: zenoh.Session, key: str, limit_s: float = _PATIENCE_S) -> list[bytes]:
    """Return the answers to a query."""
    return [one.ok.payload.to_bytes() for one in session.get(key, timeout=limit_s) if one.ok]
