"""Identifies a process, even if another one gets its number later."""

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
        """Return the identity of this process."""
        pid = os.getpid()
        return cls(pid=pid, started=_started(pid) or 0, boot=_boot())

    @property
    def has_ended(self) -> bool:
        """Whether the process has ended; False for one of another machine or another boot."""
        return self.boot == _boot() and _started(self.pid) != self.started


def _boot() -> str:
    return Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip()


def _started(pid: int) -> int | None:
    """Return the start time that the kernel reports; None if there is no such process."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
    except OSError:
        return None
    # Count from the end of the name, which may hold anything: state is field 3, start time 22.
    return int(stat[stat.rindex(b")") + 2 :].split()[19])
