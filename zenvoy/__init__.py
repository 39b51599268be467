"""Run fleets of vehicles that talk to each other, from Python.

    import zenvoy

    run = zenvoy.run(zenvoy.scenario("quickstart", duration_s=10), engine="in-process")
    run.truth["speed"]  # m/s, (cycles + 1, vehicles)
    run.summary["smallest_gap_m"]

Each name is imported on first use, so that `import zenvoy` is fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from zenvoy.errors import (
        FolderError,
        InputError,
        LogError,
        ProcessLostError,
        RunError,
        ScenarioError,
        ZenvoyError,
    )
    from zenvoy.result import Run, load
    from zenvoy.running import Progress, run
    from zenvoy.settings import Loaded, scenario

    __version__: str

__all__ = [
    "FolderError",
    "InputError",
    "Loaded",
    "LogError",
    "ProcessLostError",
    "Progress",
    "Run",
    "RunError",
    "ScenarioError",
    "ZenvoyError",
    "__version__",
    "load",
    "run",
    "scenario",
]

_MODULES: Final = {
    "errors": (
        "FolderError",
        "InputError",
        "LogError",
        "ProcessLostError",
        "RunError",
        "ScenarioError",
        "ZenvoyError",
    ),
    "result": ("Run", "load"),
    "running": ("Progress", "run"),
    "settings": ("Loaded", "scenario"),
}
_HOME: Final = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        found: Any = import_module("importlib.metadata").version("zenvoy")
    elif name in _HOME:
        found = getattr(import_module(f"zenvoy.{_HOME[name]}"), name)
    else:
        raise AttributeError(f"module 'zenvoy' has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
