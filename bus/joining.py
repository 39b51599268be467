"""Queries of a process that joins a run later, and the answers of the world."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

import zenoh

from zenvoy.bus.clock import wall_ns
from zenvoy.bus.clock_bounds import Offset
from zenvoy.bus.doors import Doors
from zenvoy.bus.errors import NoAnswerError, RouterError
from zenvoy.bus.far_clock import measured
from zenvoy.bus.querying import Answer, answer, reply_to
from zenvoy.bus.runs import offer_about, the_run
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import alive_key, host_key, processes_key, scenario_key
from zenvoy.bus.vehicle_processes import VehicleProcess

OnArrival = Callable[[str, str, bool], None]
"""Called with a process, its host ("" where that is unknown), and whether it is there now."""

_HINT: Final = (
    "; nor does it answer a certificate of another authority, of another vehicle, that has "
    "expired, or that is not in members.txt"
)


class RunState(NamedTuple):
    """The state of a run: its name, its effective scenario, as JSON, and its processes.

    present: names of the running processes. shared: vehicles of each shared process, whether
    it is running or not. clock: the offset of the world's clock, if the run is in real time.
    """

    run: str
    scenario: bytes
    present: frozenset[str]
    shared: dict[str, list[int]]
    clock: Offset | None = None


def _ignore(_process: str, _host: str, _there: bool) -> None:
    """Do nothing."""


def offer(
    session: zenoh.Session,
    run: str,
    size: int,
    shared: Sequence[VehicleProcess],
    scenario: Answer,
    on_arrival: OnArrival = _ignore,
) -> tuple[object, ...]:
    """Answer queries for the state of `run`, as long as the result is kept.

    `on_arrival` is called from a thread of Zenoh.

    A joining process cannot see the tokens of other vehicles, because peers relay nothing. The
    world sees all of them.
    """
    present: set[str] = set()

    def note(sample: zenoh.Sample) -> None:
        name = str(sample.key_expr).rpartition("/")[2]
        there = sample.kind == zenoh.SampleKind.PUT
        (present.add if there else present.discard)(name)
        on_arrival(name, "", there)

    def note_host(sample: zenoh.Sample) -> None:
        *_, name, host = str(sample.key_expr).split("/")
        if sample.kind == zenoh.SampleKind.PUT:
            on_arrival(name, host, True)

    def processes() -> bytes:
        several = {process.name: process.vehicles for process in shared}
        return json.dumps({"present": sorted(present), "shared": several}).encode()

    return (
        session.liveliness().declare_subscriber(alive_key(run), note, history=True),
        session.liveliness().declare_subscriber(host_key(run), note_host, history=True),
        answer(session, processes_key(run), processes),
        answer(session, scenario_key(run), scenario),
        offer_about(session, run, size, shared, present),
    )


def ask(
    run: str | None,
    connect: Sequence[str],
    limit_s: float,
    doors: Doors | None = None,
    *,
    router: bool = False,
) -> RunState:
    """Return the state of the run whose world is at one of the endpoints; None: the only one.

    With `router`, they are those of Zenoh routers. Raises NoAnswerError, or SeveralRunsError, which
    lists the runs.
    """
    try:
        # A listener accepts the default transport besides the low-latency one.
        session = open_session([], connect, realtime=True, doors=doors, router=router)
    except RouterError as error:
        raise NoAnswerError(str(error)) from error
    except zenoh.ZError as error:
        raise NoAnswerError(
            f"{', '.join(connect)}: no endpoint such as tcp/<host>:<port> or unixsock-stream/<path>"
        ) from error
    with session:
        deadline_ns = wall_ns() + round(limit_s * 1e9)
        run = the_run(session, deadline_ns) if run is None else run
        scenario = None if run is None else reply_to(session, scenario_key(run), deadline_ns)
        processes = None if run is None else reply_to(session, processes_key(run), deadline_ns)
        clock = None
        if run is not None and scenario is not None and _is_in_real_time(scenario):
            clock = measured(session, run, limit_s)
    if run is None or scenario is None or processes is None:
        hint = _HINT if any(endpoint.startswith("tls/") for endpoint in connect) else ""
        raise NoAnswerError(f"no answer within {limit_s:g} s from {', '.join(connect)}{hint}")
    try:
        return _state(run, scenario, json.loads(processes))._replace(clock=clock)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise NoAnswerError(
            f"the answer from {', '.join(connect)} is not that of a run of Zenvoy"
        ) from error


def _is_in_real_time(scenario: bytes) -> bool:
    try:
        return bool(json.loads(scenario).get("clock") == "realtime")
    except (ValueError, AttributeError, RecursionError):
        return False  # the reader of the scenario says what is wrong


def _state(run: str, scenario: bytes, answer: Any) -> RunState:
    shared = {str(name): [int(one) for one in ids] for name, ids in answer["shared"].items()}
    return RunState(run, scenario, frozenset(map(str, answer["present"])), shared)


def at_end(session: zenoh.Session, run: str, call: Callable[[], None]) -> object:
    """Call `call` when the world of `run` disappears, as long as the result is kept."""

    def note(sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.DELETE:
            call()

    return session.liveliness().declare_subscriber(alive_key(run, "world"), note, history=True)
