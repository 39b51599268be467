"""Zenoh sessions, configured as was measured to be fastest here (docs/decisions.md)."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Final

import zenoh

# Read by the runtime when the first session of a process is opened.
_ONE_WORKER: Final = (
    "(app:(worker_threads:1),rx:(handover:app),tx:(handover:app),"
    "net:(handover:app),acc:(handover:app))"
)


def open_session(listen: Sequence[str], connect: Sequence[str]) -> zenoh.Session:
    """Peer session on explicit endpoints: no scouting, no relay, low-latency transport."""
    os.environ.setdefault("ZENOH_RUNTIME", _ONE_WORKER)
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
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def prefer_throughput() -> None:
    """Ask the scheduler for long turns (SCHED_BATCH, unprivileged): fewer switches per cycle."""
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
