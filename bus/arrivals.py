"""What has come and was not read yet, with a reader that is not woken for everything."""

from __future__ import annotations

from collections import deque
from queue import Empty, SimpleQueue
from typing import Final, Generic, TypeVar

from zenvoy.bus.clock import wall_ns

T = TypeVar("T")

# Items that do not wake the reader alone wake it when so many have gathered. With fewer of them it
# wakes up more often; with more it has too much to do at its deadline.
_WAKE_AFTER: Final = 8


class Arrivals(Generic[T]):
    """A queue for one reader. Some items wake it only when several of them have gathered."""

    def __init__(self) -> None:
        self._waking: SimpleQueue[T | None] = SimpleQueue()  # None: enough items are waiting
        self._waiting: deque[T] = deque()
        self._catching_up = False

    def __len__(self) -> int:
        return len(self._waiting) + self._waking.qsize()

    def put(self, item: T) -> None:
        """Add one, and wake the reader."""
        self._waking.put(item)

    def put_without_waking(self, item: T) -> None:
        """Add one that may wait until its reader is awake."""
        self._waiting.append(item)
        if len(self._waiting) % _WAKE_AFTER == 0:
            self._waking.put(None)

    def get(self, until_ns: int) -> T:
        """The next one; by `until_ns` of wall time there must be one, or Empty is raised."""
        while True:
            if self._catching_up and self._waiting:
                return self._waiting.popleft()
            self._catching_up = False
            try:
                item = self._waking.get(timeout=max(0, until_ns - wall_ns()) * 1e-9)
            except Empty:
                if not self._waiting:
                    raise
                item = None
            if item is not None:
                return item
            self._catching_up = True
