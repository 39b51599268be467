"""Names of runs in a comparison: those given, or else what tells their logs apart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


class LabelError(Exception):
    """Logs or labels that make no comparison."""


def labels_for(logs: Sequence[Path], given: Sequence[str]) -> list[str]:
    """A name for each log, no two the same; raises LabelError."""
    if len(logs) < 2:
        raise LabelError(f"{logs[0]}: one run alone; name two or more to compare")
    if not given:
        return _distinct(logs)
    if len(given) != len(logs):
        raise LabelError(f"--label: {len(given)} for {len(logs)} runs; give one for each, or none")
    for label in given:
        if not label.strip() or given.count(label) > 1:
            raise LabelError(f"--label '{label}': each run needs a name of its own")
    return list(given)


def _distinct(logs: Sequence[Path]) -> list[str]:
    """Names of the files, or of the folders they are in, where these differ; or else numbers."""
    folders = [log.absolute().parent for log in logs]
    for names in (
        [log.stem for log in logs],
        [folder.name for folder in folders],
        [f"{folder.parent.name}/{folder.name}" for folder in folders],
    ):
        if len(set(names)) == len(names):
            return names
    return [f"run {number}" for number in range(1, len(logs) + 1)]
