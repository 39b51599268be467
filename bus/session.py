"""Opens Zenoh sessions with the settings that measured fastest (docs/decisions.md)."""

from __future__ import annotations

import json
import os
import re
import threading
from collections.abc import Sequence
from typing import Final

import zenoh

from zenvoy.bus.doors import Doors
from zenvoy.bus.errors import RouterError

# The runtime reads this when a process opens its first session. With a single worker, about one
# process in 15,000 hung while it declared its first subscriber: the worker waited for a lock on the
# routing tables whose holder waited for the worker (zenoh-c issue 1308). The two links of a vehicle
# cannot occupy four workers.
_FEW_WORKERS: Final = (
    "(app:(worker_threads:4),rx:(handover:app),tx:(handover:app),"
    "net:(handover:app),acc:(handover:app))"
)


# In real time no process may wait for one that is stopped. Messages that it does not read are
# queued, at most 16 batches of 64 KiB, and then dropped. The low-latency transport would block.
_IN_REAL_TIME: Final[dict[str, object]] = {
    "transport/unicast/lowlatency": False,
    "transport/link/tx/queue/size/data": 16,
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 100,  # µs
}

# A router with default settings has no low-latency transport. A router that is not there is an
# error, because nothing ends a wait for it: Python's signal handlers do not run in the meantime.
_AT_A_ROUTER: Final[dict[str, object]] = {
    "mode": "client",
    "transport/unicast/lowlatency": False,
    "connect/timeout_ms": 10_000,
}

_SOURCE: Final = re.compile(r" at \S+\.rs:\d+\.?")  # a place in Zenoh's code
_LONGEST: Final = 200  # characters of an error of Zenoh

_NICENESS: Final = 5  # reduces the scheduler's weight to a third


def open_session(
    listen: Sequence[str],
    connect: Sequence[str],
    *,
    realtime: bool = False,
    doors: Doors | None = None,
    router: bool = False,
) -> zenoh.Session:
    """Open a peer session on explicit endpoints, without scouting or relay.

    Lock-step uses the low-latency transport, which blocks if a peer does not read. Real time uses
    the default transport. Both ends of a link must use the same one. `doors` are for TLS endpoints.
    With `router`, the endpoints are those of Zenoh routers, and the session is a client of one;
    raises RouterError if none lets it in.
    """
    os.environ.setdefault("ZENOH_RUNTIME", _FEW_WORKERS)
    settings: dict[str, object] = {
        "mode": "peer",
        "listen/endpoints": list(listen),
        "connect/endpoints": list(connect),
        "connect/timeout_ms": -1,
        "connect/retry": {
            "period_init_ms": 50,
            "period_max_ms": 200,
            "period_increase_factor": 1.5,
        },
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "timestamping/enabled": False,
        "transport/unicast/qos/enabled": False,
        "transport/unicast/lowlatency": True,
        "transport/shared_memory/enabled": False,
    }
    settings |= _IN_REAL_TIME if realtime else {}
    settings |= _AT_A_ROUTER if router else {}
    if doors is not None:
        settings |= doors.settings
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        if not router:
            raise
        why = _SOURCE.sub("", " ".join(str(error).split()))[:_LONGEST]
        raise RouterError(f"no session with the router {', '.join(connect)}: {why}") from error


def give_way() -> None:
    """Give this thread a lower priority than world, channel and Zenoh's threads.

    Zenoh's threads note when messages arrive. On Linux each thread has its own niceness.
    """
    thread = threading.get_native_id()
    nice = os.getpriority(os.PRIO_PROCESS, thread)
    os.setpriority(os.PRIO_PROCESS, thread, min(19, nice + _NICENESS))
