"""Which runs there are at some endpoints: each world says so, and who is missing in its run."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from typing import NamedTuple

import zenoh

from zenvoy.bus.errors import SeveralRunsError
from zenvoy.bus.querying import all_replies, answer
from zenvoy.bus.topics import about_key, plain_name, vehicle_name
from zenvoy.bus.vehicle_processes import VehicleProcess


class About(NamedTuple):
    """The name of a run, the size of its fleet, and how many of its vehicles are there."""

    run: str
    size: int
    there: int


def offer_about(
    session: zenoh.Session,
    run: str,
    size: int,
    shared: Sequence[VehicleProcess],
    present: Collection[str],
) -> object:
    """Answer queries for the runs there are, as long as the result is kept.

    `present` are the names of the processes that are there, and changes as they come and go.
    """
    placed = {vehicle: process.name for process in shared for vehicle in process.vehicles}
    names = [placed.get(one) or vehicle_name(one, size) for one in range(1, size + 1)]

    def about() -> bytes:
        there = sum(name in present for name in names)
        return json.dumps({"size": size, "there": there}).encode()

    return answer(session, about_key(run), about)


def the_run(session: zenoh.Session, deadline_ns: int) -> str | None:
    """Return the name of the only run there is, or None if there is none in time.

    Raises SeveralRunsError, which lists them.
    """
    found = sorted(
        about
        for key, payload in all_replies(session, about_key(), deadline_ns)
        if (about := _about(key, payload)) is not None
    )
    if len(found) > 1:
        several = ", ".join(f"{one.run} ({one.there} of {one.size} vehicles)" for one in found)
        raise SeveralRunsError(f"there are {len(found)} runs, with the vehicles there: {several}")
    return found[0].run if found else None


def _about(key: str, payload: bytes) -> About | None:
    """Return what a world says of its run; None for what is no such answer."""
    try:
        answer = json.loads(payload)
        return About(plain_name(key.split("/")[1]), int(answer["size"]), int(answer["there"]))
    except (ValueError, TypeError, KeyError, IndexError, RecursionError):
        return None
