"""What has come and was not read yet, with a reader that is not woken for everything."""

from __future__ import annotations

from collections import deque
from queue import Empty, SimpleQueue
from typing import Final, Generic, TypeVar

from zenvoy.bus.clock import wall_ns

T = TypeVar("T")

# Of what is quiet: so much at a time costs its reader less than to be woken for each, and leaves
# little to do at the deadline.
_MUCH: Final = 8


class Arrivals(Generic[T]):
    """A queue for one reader, who sleeps on through what is quiet until there is much of it."""

    def __init__(self) -> None:
        self._loud: SimpleQueue[T | None] = SimpleQueue()  # None: there is much that is quiet
        self._quiet: deque[T] = deque()
        self._catching_up = False

    def __len__(self) -> int:
        return len(self._quiet) + self._loud.qsize()

    def put(self, item: T) -> None:
        """Add one, and wake the reader."""
        self._loud.put(item)

    def put_quietly(self, item: T) -> None:
        """Add one that may wait until its reader is awake."""
        self._quiet.append(item)
        if len(self._quiet) % _MUCH == 0:
            self._loud.put(None)

    def get(self, until_ns: int) -> T:
        """The next one; by `until_ns` of wall time there must be one, or Empty is raised."""
        while True:
            if self._catching_up and self._quiet:
                return self._quiet.popleft()
            self._catching_up = False
            try:
                item = self._loud.get(timeout=max(0, until_ns - wall_ns()) * 1e-9)
            except Empty:
                if not self._quiet:
                    raise
                item = None
            if item is not None:
                return item
            self._catching_up = True
