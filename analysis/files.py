"""What an analysis leaves on disk: files that are there whole, or not at all."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from zenvoy.analysis.section import Sheet

# What a spreadsheet takes for a formula, at the start of a cell or behind a separator in it; the
# wide forms count there as well. A number is none.
_FORMULA: Final = re.compile(r"(^|[;\t\r\n])(\s*)(?=[=+\-@＝＋－＠])")
_CONTROLS: Final = {code: f"\\x{code:02x}" for code in range(0x20) if chr(code) not in "\t\n\r"}
_NUMBER: Final = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?|[+-]?(inf|nan)", re.IGNORECASE)


def harmless(cell: object) -> object:
    """A cell of a CSV; a text that a spreadsheet would run as a formula, behind an apostrophe.

    So OWASP's page on CSV injection has it. Names of runs and scenarios come from anywhere.
    """
    if not isinstance(cell, str) or _NUMBER.fullmatch(cell):
        return cell
    return _FORMULA.sub(r"\1\2'", cell)


def utf8(text: str) -> bytes:
    """A text as files have it, whatever the locale.

    What is no character, such as a byte of a name that is no UTF-8, stands as its number.
    """
    return text.translate(_CONTROLS).encode("utf-8", "backslashreplace")


def csv_bytes(sheet: Sheet) -> bytes:
    """A sheet with all its digits, the names of its columns first; nothing where it has None."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for row in (sheet.columns, *sheet.rows):
        writer.writerow(map(harmless, row))
    return utf8(text.getvalue())


def write_whole(folder: Path, files: Mapping[str, bytes]) -> list[Path]:
    """Write files by name into a folder that exists; their paths.

    None is put in place before all are written: a disk that is full leaves the folder as it was.
    Raises OSError.
    """
    with TemporaryDirectory(prefix=".zenvoy-", dir=folder) as unfinished:
        for name, content in files.items():
            (Path(unfinished) / name).write_bytes(content)
        return [(Path(unfinished) / name).replace(folder / name) for name in files]
