"""Tells a process from another that gets its number later."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Self


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessId:
    """A process: its number, its start time (clock ticks since boot), and which boot."""

    pid: int
    started: int
    boot: str

    @classmethod
    def own(cls) -> Self:
        """The process that asks."""
        pid = os.getpid()
        return cls(pid=pid, started=_started(pid) or 0, boot=_boot())

    @property
    def has_ended(self) -> bool:
        """Whether it is known to be gone; False where it is of another machine, or another boot."""
        return self.boot == _boot() and _started(self.pid) != self.started


def _boot() -> str:
    return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()


def _started(pid: int) -> int | None:
    """Start time as the kernel tells it; None where there is no such process."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:
        return None
    # Behind the name, which may hold anything: the state is field 3, the start time field 22.
    return int(stat[stat.rindex(b")") + 2 :].split()[19])
