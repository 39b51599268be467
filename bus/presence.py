"""Which processes of a run are there, by their liveliness tokens."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Collection
from typing import Any

import zenoh

from zenvoy.bus.topics import alive_key


class Presence:
    """Follows the tokens of the processes of these names, of which `most` changes may wait."""

    def __init__(self, names: Collection[str], most: int) -> None:
        self.started = Counter[str]()
        """How often a process has become ready."""
        self._names = frozenset(names)
        self._most = most
        self._ready: set[str] = set()  # processes whose tokens are there
        self._changes = deque[tuple[str, bool]](maxlen=most)
        self._alive: zenoh.Subscriber[Any] | None = None

    def follow(self, session: zenoh.Session, run: str) -> None:
        """Begin to follow the tokens of a run, also those that are there already."""
        self._alive = session.liveliness().declare_subscriber(
            alive_key(run), zenoh.handlers.FifoChannel(self._most), history=True
        )

    def wait(self) -> tuple[str, bool]:
        """Wait for the next token; return whose it is, and whether it is there or gone."""
        assert self._alive is not None
        return self._noted(self._alive.recv())

    def note(self) -> None:
        """Take in the changes so far."""
        while self._alive is not None and (sample := self._alive.try_recv()) is not None:
            name, there = self._noted(sample)
            if name in self._names:  # other programs may declare tokens too
                self._changes.append((name, there))

    def changes(self) -> list[tuple[str, bool]]:
        """Return the processes that have come (True) or gone since the last call, in order."""
        self.note()
        found = list(self._changes)
        self._changes.clear()
        return found

    def _noted(self, sample: zenoh.Sample) -> tuple[str, bool]:
        """Note that the token of a process is there or gone; it may be reported twice."""
        name = str(sample.key_expr).rpartition("/")[2]
        there = sample.kind == zenoh.SampleKind.PUT
        if there and name in self._names and name not in self._ready:
            self.started[name] += 1
        if there:
            self._ready.add(name)
        else:
            self._ready.discard(name)
        return name, there
