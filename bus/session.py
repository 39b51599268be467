"""Zenoh sessions, configured as was measured to be fastest here (docs/decisions.md)."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Sequence
from typing import Final

import zenoh

# Read by the runtime when the first session of a process is opened. With a single worker about one
# process in 15,000 never came out of the declaration of its first subscriber: its worker waited for
# a lock of the routing tables, whose holder waited for the worker (zenoh-c issue 1308). A vehicle's
# two links cannot keep all of these busy.
_FEW_WORKERS: Final = (
    "(app:(worker_threads:4),rx:(handover:app),tx:(handover:app),"
    "net:(handover:app),acc:(handover:app))"
)


# In real time nobody may have to wait for a process that is stopped: what it does not read is
# queued, 16 batches of 64 KiB at most, and then dropped. The low-latency transport would block.
_IN_REAL_TIME: Final[dict[str, object]] = {
    "transport/unicast/lowlatency": False,
    "transport/link/tx/queue/size/data": 16,
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 100,  # µs
}

_GIVES_WAY: Final = 5  # a third of the weight


def open_session(
    listen: Sequence[str], connect: Sequence[str], *, realtime: bool = False
) -> zenoh.Session:
    """Peer session on explicit endpoints: no scouting, no relay.

    Lock-step uses the low-latency transport, which blocks where a peer does not read. Real time
    uses the default one. Both ends of a link must be of the same kind.
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
    config = zenoh.Config()
    for key, value in (settings | (_IN_REAL_TIME if realtime else {})).items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def give_way() -> None:
    """Let world and channel go first, and Zenoh's threads, which say when a message came.

    Of this thread alone: Linux has a niceness for each.
    """
    thread = threading.get_native_id()
    nice = os.getpriority(os.PRIO_PROCESS, thread)
    os.setpriority(os.PRIO_PROCESS, thread, min(19, nice + _GIVES_WAY))
