"""Helpers read the blocks of code of a page in docs/, which tests then run."""

from __future__ import annotations

import re


def blocks(page: str, language: str) -> list[str]:
    """Return the contents of all blocks in this language, in order."""
    return re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)


def named_blocks(page: str) -> list[tuple[str, str, str]]:
    """Return language, file name ("" for commands) and content of each block, in order."""
    return re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
