"""Finds frozen processes: those that a signal or a debugger has stopped."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from zenvoy.fleet.spawn import Child

_STOPPED_STATES: Final = "Tt"  # in /proc/<pid>/stat


class Frozen:
    """Keeps track of which children are frozen, and since when."""

    def __init__(self, limit_s: float) -> None:
        self._limit_ns = round(limit_s * 1e9)
        self._since_ns: dict[int, tuple[Child, int]] = {}  # by pidfd
        self._reported: set[int] = set()

    @property
    def names(self) -> list[str]:
        """The names of children found frozen by the last `look`, the longest frozen first."""
        found = sorted(self._since_ns.values(), key=lambda one: one[1])
        return [child.program.name for child, _ in found]

    def look(self, children: Iterable[Child], now_ns: int) -> None:
        """Find out which of the children are frozen now."""
        frozen = {child.pidfd: child for child in children if _is_frozen(child.pid)}
        self._since_ns = {
            pidfd: (child, self._since_ns.get(pidfd, (child, now_ns))[1])
            for pidfd, child in frozen.items()
        }
        self._reported &= frozen.keys()

    def due(self, now_ns: int) -> list[Child]:
        """Return the children that have been frozen for the limit, each of them once."""
        found = [
            child
            for pidfd, (child, since_ns) in self._since_ns.items()
            if now_ns - since_ns >= self._limit_ns and pidfd not in self._reported
        ]
        self._reported.update(child.pidfd for child in found)
        return found


def _is_frozen(pid: int) -> bool:
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:  # it has just ended, or no file descriptor is free
        return False
    return chr(stat[stat.rindex(b")") + 2]) in _STOPPED_STATES
