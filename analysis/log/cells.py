"""Escapes cells of tables that a spreadsheet would run as formulas."""

from __future__ import annotations

import re
from typing import Final

# A spreadsheet takes these for the start of a formula, at the beginning of a cell or after a
# separator in it, full-width forms included. A number is not a formula.
_FORMULA: Final = re.compile(r"(^|[;\t\r\n])(\s*)(?=[=+\-@＝＋－＠])")
_NUMBER: Final = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?|[+-]?(inf|nan)", re.IGNORECASE)


def harmless(cell: object) -> object:
    """Return a cell of a CSV file, with an apostrophe before text that would run as a formula.

    OWASP's page on CSV injection recommends this. Names of runs and scenarios come from anywhere.
    """
    if not isinstance(cell, str) or _NUMBER.fullmatch(cell):
        return cell
    return _FORMULA.sub(r"\1\2'", cell)
