"""A queue of items whose reader is not woken for every item."""

from __future__ import annotations

from collections import deque
from queue import Empty, SimpleQueue
from typing import Final, Generic, TypeVar

from zenvoy.bus.clock import wall_ns

T = TypeVar("T")

# Items that do not wake the reader by themselves wake it when so many have gathered. A lower number
# wakes it more often; a higher one leaves it too much to do at its deadline.
_WAKE_AFTER: Final = 8


class Arrivals(Generic[T]):
    """A queue for one reader. Some items wake the reader only when several have gathered."""

    def __init__(self) -> None:
        self._waking: SimpleQueue[T | None] = SimpleQueue()  # None: enough items are waiting
        self._waiting: deque[T] = deque()
        self._catching_up = False

    def __len__(self) -> int:
        return len(self._waiting) + self._waking.qsize()

    def put(self, item: T) -> None:
        """Add an item, and wake the reader."""
        self._waking.put(item)

    def put_without_waking(self, item: T) -> None:
        """Add an item that may wait until the reader is awake."""
        self._waiting.append(item)
        if len(self._waiting) % _WAKE_AFTER == 0:
            self._waking.put(None)

    def get(self, until_ns: int) -> T:
        """Return the next item; raises Empty if there is none by `until_ns` of wall time."""
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
