"""Kills the process of a vehicle at the request of a person who watches the run."""

from __future__ import annotations

import os
import signal
from pathlib import Path


def kill_process(name: str, run: str, parent: int) -> bool:
    """Kill the process of that name in a run, a child of `parent`; return whether there was one.

    It kills no other process, even if one gets the number of a process that has just ended.
    """
    for folder in Path("/proc").glob("[0-9]*"):
        if not _is(folder, name, run, parent):
            continue
        try:
            pidfd = os.pidfd_open(int(folder.name))
        except OSError:
            continue
        try:
            if _is(folder, name, run, parent):  # it still is, now that the number is held
                signal.pidfd_send_signal(pidfd, signal.SIGKILL)
                return True
        except ProcessLookupError:
            continue
        finally:
            os.close(pidfd)
    return False


def _is(folder: Path, name: str, run: str, parent: int) -> bool:
    """Return whether a folder of /proc is that of the process."""
    try:
        title = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        after_name = (folder / "stat").read_text("utf-8", errors="replace").rpartition(")")[2]
    except OSError:
        return False
    return title.split()[:3] == ["zenvoy", name, run] and after_name.split()[1] == str(parent)
