"""Helpers find the page that a command serves."""

from __future__ import annotations

import re

from tests.conftest import Command, wait_until


def address_in(viewer: Command) -> str:
    """Return the address that a command prints, once it has."""

    def found() -> re.Match[str] | None:
        return re.search(r"http://127\.0\.0\.1:\d+/", viewer.out)

    wait_until(lambda: found() is not None, "the address of the page is printed")
    match = found()
    assert match is not None
    return match[0]
