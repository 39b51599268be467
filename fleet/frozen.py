"""Which processes stand still: stopped by a signal, or held by a debugger."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from zenvoy.fleet.spawn import Child

_STANDING_STILL: Final = "Tt"  # states in /proc/<pid>/stat


class Frozen:
    """Children that stand still, and for how long they have been seen to."""

    def __init__(self, limit_s: float) -> None:
        self._limit_ns = round(limit_s * 1e9)
        self._since_ns: dict[int, tuple[Child, int]] = {}  # by pidfd
        self._told: set[int] = set()

    @property
    def names(self) -> list[str]:
        """Those that stood still at the last look, those that have for longest first."""
        found = sorted(self._since_ns.values(), key=lambda one: one[1])
        return [child.program.name for child, _ in found]

    def look(self, children: Iterable[Child], now_ns: int) -> None:
        """See which of them stand still now."""
        still = {child.pidfd: child for child in children if _stands_still(child.pid)}
        self._since_ns = {
            pidfd: (child, self._since_ns.get(pidfd, (child, now_ns))[1])
            for pidfd, child in still.items()
        }
        self._told &= still.keys()

    def due(self, now_ns: int) -> list[Child]:
        """Those that have stood still for the limit, each once."""
        found = [
            child
            for pidfd, (child, since_ns) in self._since_ns.items()
            if now_ns - since_ns >= self._limit_ns and pidfd not in self._told
        ]
        self._told.update(child.pidfd for child in found)
        return found


def _stands_still(pid: int) -> bool:
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:  # it has just ended, or there is no file descriptor to spare
        return False
    return chr(stat[stat.rindex(b")") + 2]) in _STANDING_STILL
