"""Decides which requests a page's server answers: those of its own page, and of nobody else.

The server listens on loopback, but a website in the user's browser can send requests there. Under a
name that it points to 127.0.0.1 it could even read the answers (DNS rebinding).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final
from urllib.parse import urlsplit

_NAMES: Final = {"127.0.0.1", "localhost", "::1"}
_OWN: Final = {"same-origin", "none"}


def refusal(headers: Mapping[str, str]) -> str | None:
    """Return why a request with these headers is refused; None if it is not."""
    host = headers.get("Host", "")
    if _name(f"//{host}") not in _NAMES:
        return f"Host {host!r} is not this machine"
    origin = headers.get("Origin")
    if origin is not None and origin != f"http://{host}":
        return f"Origin {origin!r} is another page"
    site = headers.get("Sec-Fetch-Site", "none")
    if site not in _OWN:
        return f"the request is {site}"
    return None


def _name(url: str) -> str | None:
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None
