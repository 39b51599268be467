"""Studies: many runs, several at a time, each kept as a digest or a summary.

`sweep` is imported on first use, because it needs the packages of the extra `analysis`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from zenvoy.studies.sweeps.frame import sweep

__all__ = ["sweep"]


def __getattr__(name: str) -> Any:
    if name != "sweep":
        raise AttributeError(f"module 'zenvoy.studies' has no attribute {name!r}")
    return import_module("zenvoy.studies.sweeps.frame").sweep
