"""Helpers that write damaged logs, and return what a reader reports of them."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from zenvoy.analysis import LogError, load
from zenvoy.analysis.log.load import Run

TABLES: Final = ("/fleet/truth", "/fleet/radar", "/fleet/estimate", "/fleet/command", "/clock")


def written(path: Path, content: bytes) -> Path:
    changed = path.with_name("changed.mcap")
    changed.write_bytes(content)
    return changed


def notes_or_refusal(log: Path) -> str:
    """Return the notes of a damaged log, or why it is refused, in one line."""
    try:
        return "\n".join(load(log).notes)
    except LogError as error:
        return str(error) if str(error).count("\n") == 0 else ""


def assert_begins(run: Run, whole: Run) -> None:
    """Check that row k is cycle k, as in the whole log."""
    for topic in TABLES:
        table = run[topic]
        np.testing.assert_array_equal(table["cycle"], np.arange(len(table["cycle"])))
        for name, column in table.items():
            np.testing.assert_array_equal(column, whole[topic][name][: len(column)])
    for name, column in run.frames.items():
        np.testing.assert_array_equal(column, whole.frames[name][: len(column)])
