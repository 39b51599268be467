"""Writes the files of an analysis, each whole or not at all."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from zenvoy.analysis.log.cells import harmless
from zenvoy.analysis.page.section import Sheet
from zenvoy.bus.text import utf8


def csv_bytes(sheet: Sheet) -> bytes:
    """Return a sheet as CSV with all digits, below the names of its columns; None is empty."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for row in (sheet.columns, *sheet.rows):
        writer.writerow(map(harmless, row))
    return utf8(text.getvalue())


def write_whole(folder: Path, files: Mapping[str, bytes]) -> list[Path]:
    """Write files by name into an existing folder, and return their paths.

    All are written before any is put in place, so a full disk leaves the folder as it was. Raises
    OSError.
    """
    with TemporaryDirectory(prefix=".zenvoy-", dir=folder) as unfinished:
        for name, content in files.items():
            (Path(unfinished) / name).write_bytes(content)
        return [(Path(unfinished) / name).replace(folder / name) for name in files]
