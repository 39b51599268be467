"""Names of the runs in a comparison: those given, or else names taken from the paths."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


class LabelError(Exception):
    """The logs or labels given cannot be compared."""


def labels_for(logs: Sequence[Path], given: Sequence[str]) -> list[str]:
    """Return a distinct name for each log; raises LabelError."""
    if len(logs) < 2:
        raise LabelError(f"{logs[0]}: only one run; name two or more to compare")
    if not given:
        return _distinct(logs)
    if len(given) != len(logs):
        raise LabelError(f"--label: {len(given)} for {len(logs)} runs; give one per run, or none")
    for label in given:
        if not label.strip() or given.count(label) > 1:
            raise LabelError(f"--label '{label}': each run needs a name of its own")
    return list(given)


def _distinct(logs: Sequence[Path]) -> list[str]:
    """Return the names of the files or of their folders if these differ, else numbers."""
    folders = [log.absolute().parent for log in logs]
    for names in (
        [log.stem for log in logs],
        [folder.name for folder in folders],
        [f"{folder.parent.name}/{folder.name}" for folder in folders],
    ):
        if len(set(names)) == len(names):
            return names
    return [f"run {number}" for number in range(1, len(logs) + 1)]
