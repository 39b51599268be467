"""Packages that only some studies and servers need."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

_EXTRAS: Final = {
    "distributed": "dask",
    "foxglove": "foxglove",
    "optuna": "tune",
    "pandas": "pandas",
}
"""The extra of Zenvoy that installs each."""


def missing(*packages: str) -> str | None:
    """Return a line on the first of these packages that is not installed; None if all are."""
    for package in packages:
        if find_spec(package) is None:
            return f"{package} is not installed; run: pip install 'zenvoy[{_EXTRAS[package]}]'"
    return None
