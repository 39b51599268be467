"""Imports filterpy's Kalman filters without its statistics, so that a run starts sooner.

`import filterpy` imports filterpy.stats, and that scipy.stats, which takes as long as the filters
themselves. The filters use one function of it, logpdf, for likelihoods that no vehicle asks for.
So filterpy.stats is imported at its first use.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import Any, Final

_STATISTICS: Final = "filterpy.stats"


def _logpdf(*arguments: Any, **named: Any) -> Any:
    """Call filterpy.stats.logpdf."""
    return importlib.import_module(_STATISTICS).logpdf(*arguments, **named)


def _late(name: str) -> ModuleType:
    """Import filterpy.stats when somebody looks it up in the package, where filterpy puts it."""
    if name == "stats":
        return importlib.import_module(_STATISTICS)
    raise AttributeError(f"module 'filterpy' has no attribute {name!r}")


def _import_filters() -> None:
    if "filterpy" in sys.modules:
        return
    stand_in = ModuleType(_STATISTICS)
    vars(stand_in)["logpdf"] = _logpdf
    sys.modules[_STATISTICS] = stand_in
    try:
        package = importlib.import_module("filterpy")
    finally:
        del sys.modules[_STATISTICS]
    vars(package).pop("stats", None)
    vars(package)["__getattr__"] = _late


_import_filters()

from filterpy.kalman import (  # noqa: E402 - after the stand-in
    ExtendedKalmanFilter,
    KalmanFilter,
    MerweScaledSigmaPoints,
    UnscentedKalmanFilter,
)

__all__ = [
    "ExtendedKalmanFilter",
    "KalmanFilter",
    "MerweScaledSigmaPoints",
    "UnscentedKalmanFilter",
]
