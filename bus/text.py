"""Encodes text for files and logs as UTF-8 in any locale, without control characters."""

from __future__ import annotations

from typing import Final

_CONTROLS: Final = {code: f"\\x{code:02x}" for code in range(0x20) if chr(code) not in "\t\n\r"}


def utf8(text: str) -> bytes:
    """Return the text in UTF-8.

    Anything that is not a valid character, such as a byte of a file name that is not UTF-8, becomes
    an escape.
    """
    return text.translate(_CONTROLS).encode("utf-8", "backslashreplace")
