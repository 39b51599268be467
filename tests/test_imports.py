"""Imports point one way: as the arrows of DESIGN.md section 1 do."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).parents[1]

BELOW: Final = {"bus", "scenarios"}
MAY_IMPORT: Final[dict[str, set[str]]] = {
    "scenarios": set(),
    "bus": set(),
    "vehicles": BELOW,
    "channel": BELOW,
    "world": BELOW,
    "analysis": BELOW,
    "cli": {"analysis", "world", "channel", "vehicles", *BELOW},
}


def imported(tree: ast.AST) -> Iterator[str]:
    """Dotted name of everything that is imported, wherever in the file."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                yield "." * node.level + (node.module or "")
            else:
                yield from (f"{node.module}.{alias.name}" for alias in node.names)


def complaints(source: str, package: str, module: str) -> list[str]:
    """What is wrong with the imports of a module of one of the seven packages."""
    found = []
    for name in imported(ast.parse(source)):
        first, _, rest = name.partition(".")
        other = rest.partition(".")[0]
        if not first:
            found.append(f"{name}: relative")
        elif first in MAY_IMPORT:
            found.append(f"{name}: bare import of one of our folders")
        elif first == "time" and (package, module) != ("bus", "clock"):
            found.append(f"{name}: only bus/clock.py reads a clock")
        elif first == "zenvoy" and other != package and other not in MAY_IMPORT[package]:
            found.append(f"{name}: not from {package}")
    return found


MODULES: Final = sorted(path for package in MAY_IMPORT for path in (ROOT / package).rglob("*.py"))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_one_way(path: Path) -> None:
    package = path.relative_to(ROOT).parts[0]
    assert complaints(path.read_text(), package, path.stem) == []


def test_every_package_is_looked_at() -> None:
    assert {path.relative_to(ROOT).parts[0] for path in MODULES} == set(MAY_IMPORT)
    assert {path.parent.name for path in ROOT.glob("*/__init__.py")} == set(MAY_IMPORT)


@pytest.mark.parametrize(
    ("package", "source"),
    [
        ("vehicles", "from zenvoy.world.fleet import Fleet"),
        ("vehicles", "import zenvoy.world.dynamics as d"),
        ("vehicles", "from zenvoy import world"),
        ("vehicles", "from zenvoy import bus, world"),
        ("world", "from zenvoy.vehicles import agent"),
        ("channel", "def late():\n    from zenvoy.analysis import log"),
        ("analysis", "if True:\n    import zenvoy.cli.app"),
        ("bus", "from zenvoy.scenarios import Scenario"),
        ("scenarios", "from zenvoy.bus import topics"),
        ("bus", "import zenvoy"),
        ("cli", "from . import fleet"),
        ("cli", "from ..world import fleet"),
        ("cli", "import world"),
        ("cli", "from bus.topics import SENSE"),
        ("world", "import time"),
        ("world", "import time as t"),
        ("bus", "from time import monotonic_ns"),
    ],
)
def test_a_wrong_import_is_found(package: str, source: str) -> None:
    assert len(complaints(source, package, "made_up")) == 1


@pytest.mark.parametrize(
    ("package", "module", "source"),
    [
        ("bus", "clock", "import time"),
        ("cli", "run", "from zenvoy.world.process import run_world\nimport zenvoy.bus.clock"),
        ("world", "agent", "from zenvoy.world.fleet import Fleet\nfrom zenvoy.bus import draws"),
        ("analysis", "log", "import timeit\nfrom datetime import time\nimport numpy as np"),
    ],
)
def test_a_right_import_is_none(package: str, module: str, source: str) -> None:
    assert complaints(source, package, module) == []
