"""A helper reads what the processes of a run in real time had to say."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

_LATE: Final = re.compile(
    r"[\w-]+: (refused: stale, on '[\w/-]+'|messages refused: \d+ stale)", re.ASCII
)


def complaints(out: Path) -> list[str]:
    """Return the lines in the logs of all processes, except that a message came too late.

    A busy machine may hold up a process for longer than its messages stay valid.
    """
    lines = [line for file in (out / "logs").iterdir() for line in file.read_text().splitlines()]
    return [line for line in lines if not _LATE.fullmatch(line)]
