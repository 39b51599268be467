"""Cells of tables: none that a spreadsheet runs as a formula."""

from __future__ import annotations

import re
from typing import Final

# What a spreadsheet takes for a formula, at the start of a cell or behind a separator in it; the
# wide forms count there as well. A number is none.
_FORMULA: Final = re.compile(r"(^|[;\t\r\n])(\s*)(?=[=+\-@＝＋－＠])")
_NUMBER: Final = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?|[+-]?(inf|nan)", re.IGNORECASE)


def harmless(cell: object) -> object:
    """A cell of a CSV; a text that a spreadsheet would run as a formula, behind an apostrophe.

    So OWASP's page on CSV injection has it. Names of runs and scenarios come from anywhere.
    """
    if not isinstance(cell, str) or _NUMBER.fullmatch(cell):
        return cell
    return _FORMULA.sub(r"\1\2'", cell)
