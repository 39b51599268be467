"""The clock of the world's machine, as another machine knows it from round trips."""

from __future__ import annotations

from collections import deque
from typing import Final

import zenoh

from zenvoy.bus.clock import wall_ns
from zenvoy.bus.clock_bounds import ClockBounds, Offset
from zenvoy.bus.querying import answer, reply_to
from zenvoy.bus.topics import time_key

_EVERY_NS: Final = 250_000_000  # in it, bounds widen by no more than a quarter of a millisecond
_AT_FIRST: Final = 16  # round trips before the vehicles of a process may take part
_MOST_DIGITS: Final = 20
_LIMIT_S: Final = 2.0  # a longer round trip says nothing about a clock


def offer_clock(session: zenoh.Session, run: str) -> object:
    """Answer queries for the time on this machine's clock, as long as the result is kept."""
    return answer(session, time_key(run), lambda: str(wall_ns()).encode())


def _querier(session: zenoh.Session, run: str) -> zenoh.Querier:
    """Declare a querier for the time, which hands over an answer as soon as it is there."""
    return session.declare_querier(
        time_key(run), timeout=_LIMIT_S, consolidation=zenoh.ConsolidationMode.NONE
    )


def _time_in(reply: zenoh.Reply) -> int | None:
    """Return the time in an answer, ns; None if it has none."""
    text = b"" if reply.ok is None else reply.ok.payload.to_bytes()
    return int(text) if text.isdigit() and len(text) < _MOST_DIGITS else None


class FarClock:
    """Asks the world for the time now and then, and never waits for an answer."""

    def __init__(self, session: zenoh.Session, run: str) -> None:
        self._bounds = ClockBounds()
        self._querier = _querier(session, run)
        self._trips = deque[tuple[int, int, int]](maxlen=64)  # filled by a thread of Zenoh
        self._asked_ns = 0

    def offset(self) -> Offset | None:
        """Return the offset of the world's clock now; ask for the time if that is due."""
        now_ns = wall_ns()
        if now_ns - self._asked_ns > _EVERY_NS:
            self.ask(now_ns)
        while self._trips:
            self._bounds.add(*self._trips.popleft())
        return self._bounds.at(now_ns)

    def ask(self, now_ns: int) -> None:
        """Ask the world for the time."""
        self._asked_ns = now_ns

        def note(reply: zenoh.Reply) -> None:
            back_ns = wall_ns()
            there_ns = _time_in(reply)
            if there_ns is not None:
                self._trips.append((now_ns, there_ns, back_ns))

        self._querier.get(zenoh.handlers.Callback(note, indirect=False))


def measured(session: zenoh.Session, run: str, limit_s: float) -> Offset | None:
    """Return the offset of the world's clock after some round trips; None if nobody answers."""
    bounds = ClockBounds()
    if reply_to(session, time_key(run), wall_ns() + round(limit_s * 1e9)) is None:
        return None
    with _querier(session, run) as querier:
        for _ in range(_AT_FIRST):
            sent_ns = wall_ns()
            for reply in querier.get():
                back_ns = wall_ns()
                there_ns = _time_in(reply)
                if there_ns is not None:
                    bounds.add(sent_ns, there_ns, back_ns)
    return bounds.at(wall_ns())
