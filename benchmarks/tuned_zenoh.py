"""A Zenoh session with the settings of docs/architecture.md, and readiness without a sleep.

Vehicles are peers that listen nowhere. The session uses Unix sockets, the low-latency transport,
one background thread, and blocking `recv` and `put`.
"""

import json
import os
from collections.abc import Iterable, Sequence
from typing import cast

import zenoh
from zenoh.handlers import FifoChannel, Handler

MESSAGE_LIMIT_BYTES = 60_000  # the low-latency transport loses messages above about 65,400 bytes
ROOT = "zenvoy/bare"
RUNTIME = (
    "(app:(worker_threads:1),rx:(handover:app),tx:(handover:app),net:(handover:app),"
    "acc:(handover:app))"
)

Inbox = zenoh.Subscriber[Handler[zenoh.Sample]]


def open_session(listen: Sequence[str], connect: Sequence[str]) -> zenoh.Session:
    """Open the only session of this process; it must not have opened one before."""
    os.environ["ZENOH_RUNTIME"] = RUNTIME
    retry = {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 1.5}
    config = {
        "mode": "peer",
        "listen": {"endpoints": listen},
        "connect": {"endpoints": connect, "retry": retry},
        "scouting": {"delay": 0, "multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "timestamping": {"enabled": False},
        "transport": {
            "unicast": {"qos": {"enabled": False}, "lowlatency": True},
            "shared_memory": {"enabled": False},
        },
    }
    return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))


def subscribe(session: zenoh.Session, key: str) -> Inbox:
    """Return an inbox for one stream; its `recv` blocks."""
    return session.declare_subscriber(
        f"{ROOT}/{key}", FifoChannel(4096), allowed_origin=zenoh.Locality.REMOTE
    )


def publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    """Return a publisher once it has a remote subscriber; earlier messages would be lost."""
    declared = session.declare_publisher(
        f"{ROOT}/{key}",
        congestion_control=zenoh.CongestionControl.BLOCK,
        allowed_destination=zenoh.Locality.REMOTE,
    )
    with declared.declare_matching_listener(FifoChannel(16)) as changes:
        # zenoh's stub says bool, but the object is a status, which is always true as a bool
        while not cast(zenoh.MatchingStatus, declared.matching_status).matching:
            changes.recv()
    return declared


def announce(session: zenoh.Session, name: str) -> zenoh.LivelinessToken:
    """Announce that process `name` has declared its subscribers and matched its publishers."""
    return session.liveliness().declare_token(f"{ROOT}/alive/{name}")


def await_announced(session: zenoh.Session, names: Iterable[str]) -> None:
    """Block until all processes in `names` have announced themselves."""
    missing = {f"{ROOT}/alive/{name}" for name in names}
    with session.liveliness().declare_subscriber(
        f"{ROOT}/alive/*", FifoChannel(4096), history=True
    ) as tokens:
        while missing:
            missing.discard(str(tokens.recv().key_expr))
