"""The configuration of a Zenoh router that lets in the members of a folder of certificates."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from zenvoy.bus.access import ANY_RUN, ROUTER, access_control
from zenvoy.bus.doors import Doors, Identity
from zenvoy.bus.topics import TRUTH
from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.fleet.certificates import AUTHORITY, members_in

CONFIG: Final = "router.json5"
_HEADER: Final = (
    "// For Zenoh's router, from the folder of these certificates: zenohd -c router.json5\n"
    "// zenvoy certs DIR --router makes it anew from members.txt.\n"
)


def write_router(folder: Path, listen: str, size: int, per_process: int) -> Path:
    """Write the configuration of a router that listens at an endpoint, and return its path.

    Observers may read the truth, which only scenarios that allow it publish.

    It is for any run of fleets of up to `size` vehicles; only one of exactly that size may have
    `per_process` of them share a process. Files are named relative to the folder, so that it can be
    copied. Raises CertificatesError, OSError.
    """
    shared = [one for one in vehicle_processes(size, per_process) if one.is_shared]
    access = access_control(ANY_RUN, size, shared, members_in(folder), (), public={TRUTH.name})
    identity = Identity(
        authority=Path(AUTHORITY),
        certificate=Path(f"{ROUTER}.pem"),
        key=Path(f"{ROUTER}.key"),
    )
    settings: dict[str, object] = {
        "mode": "router",
        "listen/endpoints": [listen],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        **Doors(identity=identity, access=access).settings,
    }
    path = folder / CONFIG
    path.write_text(_HEADER + json.dumps(_nested(settings), indent=1) + "\n", encoding="utf-8")
    return path


def _nested(settings: Mapping[str, object]) -> dict[str, Any]:
    """Return settings by path, such as `scouting/gossip/enabled`, as objects within objects."""
    found: dict[str, Any] = {}
    for path, value in settings.items():
        *folders, name = path.split("/")
        place = found
        for folder in folders:
            place = place.setdefault(folder, {})
        place[name] = value
    return found
