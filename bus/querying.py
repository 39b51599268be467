"""Queries of a process that knows little yet, and answers to them."""

from __future__ import annotations

from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Final, cast

import zenoh

from zenvoy.bus.clock import pause, wall_ns

# Nothing says when the first answer can come. This yields the processor to the process that
# answers.
_BETWEEN_QUERIES_S: Final = 0.05

Answer = Callable[[], bytes]


def reply_to(session: zenoh.Session, key: str, deadline_ns: int) -> bytes | None:
    """Query a key as soon as it has a queryable; return an answer, or None if none is in time."""
    changes: SimpleQueue[None] = SimpleQueue()
    with (
        session.declare_querier(key, timeout=_left_s(deadline_ns)) as querier,
        querier.declare_matching_listener(lambda _: changes.put(None)),
    ):
        # The stub types the status as a bool, but it is an object, which is always true.
        while not cast(zenoh.MatchingStatus, querier.matching_status).matching:
            try:
                changes.get(timeout=_left_s(deadline_ns))
            except Empty:
                return None
        for reply in querier.get():
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
    return None


def all_replies(session: zenoh.Session, keys: str, deadline_ns: int) -> list[tuple[str, bytes]]:
    """Query a key expression until there is an answer; return the keys and payloads of all.

    The list is empty if there is none in time. A querier with wildcards never matches, so this
    asks again and again.
    """
    while True:
        found = session.get(
            keys,
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=_left_s(deadline_ns),
        )
        answers = [(str(one.ok.key_expr), one.ok.payload.to_bytes()) for one in found if one.ok]
        if answers or wall_ns() > deadline_ns:
            return answers
        pause(_BETWEEN_QUERIES_S)


def answer(session: zenoh.Session, key: str, payload: Answer) -> zenoh.Queryable[None]:
    """Declare a queryable that answers queries on `key` with `payload()`, from its own thread."""

    def reply(query: zenoh.Query) -> None:
        with query:
            query.reply(key, payload())

    return session.declare_queryable(key, reply)


def _left_s(deadline_ns: int) -> float:
    return max(0.001, (deadline_ns - wall_ns()) * 1e-9)
