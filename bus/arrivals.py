"""What has come and was not read yet, with a reader that is not woken for everything."""

from __future__ import annotations

from collections import deque
from queue import Empty, SimpleQueue
from typing import Final, Generic, TypeVar

from zenvoy.bus.clock import wall_ns

T = TypeVar("T")

# Quiet items that wake the reader together: fewer cost it more wake-ups, more leave it too much to
# do at its deadline.
_WAKE_AFTER: Final = 8


class Arrivals(Generic[T]):
    """A queue for one reader. Quiet items wake it only when several of them have gathered."""

    def __init__(self) -> None:
        self._loud: SimpleQueue[T | None] = SimpleQueue()  # None: enough quiet items have gathered
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
        if len(self._quiet) % _WAKE_AFTER == 0:
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
