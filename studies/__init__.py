"""Studies: many runs, several at a time, each kept as a digest or a summary.

`compare_laws`, `sweep` and `tune` are imported on first use, because they need the packages of
extras.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from zenvoy.studies.comparison.frame import compare_laws
    from zenvoy.studies.sweeps.frame import sweep
    from zenvoy.studies.tuning.frame import tune

__all__ = ["compare_laws", "sweep", "tune"]

_MODULES: Final = {
    "compare_laws": "zenvoy.studies.comparison.frame",
    "sweep": "zenvoy.studies.sweeps.frame",
    "tune": "zenvoy.studies.tuning.frame",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'zenvoy.studies' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)
