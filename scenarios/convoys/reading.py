"""Reads a convoy from a file of OpenACC, a table of named columns, or what an import has kept."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Final

from zenvoy.scenarios.convoys.columns import Columns
from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.scenarios.convoys.cutting import Choice, convoy_in
from zenvoy.scenarios.convoys.errors import ConvoyError, refused
from zenvoy.scenarios.convoys.kept import KEPT, RECORDED, kept_header, setting_in
from zenvoy.scenarios.convoys.named import named_table
from zenvoy.scenarios.convoys.openacc import is_openacc, openacc_table
from zenvoy.scenarios.errors import Problem, UnreadableScenarioError
from zenvoy.scenarios.reading.origin import from_here
from zenvoy.values.wording import shown

_SUFFIXES: Final = re.compile(r"(\.csv|\.txt|\.tsv|\.gz)+$")


def read_openacc(path: Path, choice: Choice) -> Convoy:
    """Return the convoy in a file of OpenACC; raises ConvoyError."""
    table = openacc_table(_text(path), str(path), path.name)
    return convoy_in(table, choice, _name(path), str(path))


def read_table(path: Path, columns: Columns, choice: Choice) -> Convoy:
    """Return the convoy in a table with these columns; raises ConvoyError."""
    return convoy_in(named_table(_text(path), str(path), columns), choice, _name(path), str(path))


def read_convoy(path: Path, choice: Choice) -> Convoy:
    """Return the convoy in a file of OpenACC, or in the folder or the table of an import.

    Raises ConvoyError.
    """
    if path.is_dir():
        path /= RECORDED
    text = _text(path)
    if is_openacc(text):
        return read_openacc(path, choice)
    if not kept_header(text):
        what = "neither a file of OpenACC nor what zenvoy import has written; "
        what += "allowed: the folder that zenvoy import table makes of it"
        raise refused(str(path), "", what if text.strip() else "empty")
    name = path.parent.name if path.name == RECORDED else _name(path)
    found = convoy_in(named_table(text, str(path), KEPT), choice, name, str(path))
    return replace(found, setting=setting_in(text))


def _text(path: Path) -> str:
    """Return the text of a file, unpacked if its name ends in .gz."""
    try:
        return from_here(path).text()
    except UnreadableScenarioError as error:
        raise ConvoyError(error.problems) from None
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        text = f"{shown(str(path))} cannot be read: {why}"
        raise ConvoyError([Problem(key="", text=text)]) from None


def _name(path: Path) -> str:
    return _SUFFIXES.sub("", path.name)
