"""The versions that a worker must have so that its runs equal runs here, bit for bit."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Final

PACKAGES: Final = ("zenvoy", "numpy", "scipy", "filterpy")
"""The packages that compute: another version may round differently."""

Versions = Mapping[str, str | None]
"""Versions by name, with that of Python; None for a package that is not installed."""


def versions_here() -> dict[str, str | None]:
    """Return the versions of this process."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"python": python} | {name: _version(name) for name in PACKAGES}


def difference(worker: str, has: Versions, needed: Versions) -> str | None:
    """Return in one line what a worker at an address lacks, or None."""
    lacking = [
        f"{name} {has.get(name) or 'is missing'} (needed: {needed[name]})"
        for name in needed
        if has.get(name) != needed[name]
    ]
    return f"worker {worker}: {', '.join(lacking)}" if lacking else None


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
