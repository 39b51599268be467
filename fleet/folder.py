"""The folder of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from zenvoy.bus.clock import stamp

# Its files and subfolders.
LOG: Final = "run.mcap"
SUMMARY: Final = "summary.json"
LOGS: Final = "logs"
"""It has a text file per process."""


class FolderError(Exception):
    """The folder for a run cannot be made, or is not empty."""


def make_folder(out: Path | None, name: str) -> Path:
    """Make the folder of a run, with a subfolder for its logs; raises FolderError.

    `out` must be new or empty; by default the folder is `runs/<time>-<name>`.
    """
    base = Path("runs") / f"{stamp()}-{name.replace('/', '-')}"
    folder = base if out is None else out
    number = 1
    while out is None and folder.exists():
        number += 1
        folder = base.with_name(f"{base.name}-{number}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise FolderError(f"{folder}: is not empty; name a new folder or an empty one")
        (folder / LOGS).mkdir()
    except OSError as error:
        raise FolderError(f"{folder}: {error.strerror}") from error
    return folder
