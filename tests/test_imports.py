"""Imports point one way, as do the arrows in docs/architecture.md."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Final

import pytest

ROOT: Final = Path(__file__).parents[1]

BELOW: Final = {"bus", "laws", "scenarios", "links", "values", "keyed_random"}
MAY_IMPORT: Final[dict[str, set[str]]] = {
    "keyed_random": set(),
    "values": set(),
    "links": {"keyed_random", "values"},
    "laws": set(),
    "scenarios": {"laws", "links", "values"},
    "bus": set(),
    "vehicles": BELOW,
    "channel": BELOW,
    "world": BELOW,
    "analysis": BELOW,
    "fleet": {"world", "channel", "vehicles", *BELOW},
    "studies": {"fleet", "analysis", *BELOW},
    "zenvoy": {"studies", "fleet", "analysis", *BELOW},  # the façade
    "cli": {"studies", "fleet", "analysis", "world", "channel", "vehicles", *BELOW},
}

FACADE: Final = {path.stem for path in (ROOT / "zenvoy").glob("*.py")}

# Subfolders of a package. A module outside all of them is named by its file.
SUBFOLDERS: Final[dict[str, dict[str, set[str]]]] = {
    "analysis": {
        "log": set(),
        "measures": {"log"},
        "theory": {"log", "measures"},
        "page": {"log", "measures"},
        "chapters": {"log", "measures", "theory", "page"},
        "compare": {"log", "measures", "page", "chapters"},
        "paper": {"measures", "page"},
        "view": {"log"},  # it must not wait for matplotlib, which `page` imports
    },
    "scenarios": {
        "errors": set(),
        "schema": {"errors"},
        "reading": {"errors", "schema"},
        "convoys": {"errors", "schema", "reading"},
    },
}


def imported(tree: ast.AST) -> Iterator[str]:
    """Yield the dotted name of every import, anywhere in the file."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                yield "." * node.level + (node.module or "")
            else:
                yield from (f"{node.module}.{alias.name}" for alias in node.names)


def violations(source: str, package: str, module: str) -> list[str]:
    """Return what is wrong with the imports of a module of a package."""
    found = []
    own = FACADE if package == "zenvoy" else {package}
    for name in imported(ast.parse(source)):
        first, _, rest = name.partition(".")
        other = rest.partition(".")[0]
        if not first:
            found.append(f"{name}: relative")
        elif first in MAY_IMPORT.keys() - {"zenvoy"}:
            found.append(f"{name}: bare import of one of our folders")
        elif first == "time" and (package, module) != ("bus", "clock"):
            found.append(f"{name}: only bus/clock.py reads a clock")
        elif first == "zenvoy" and other not in {*own, *MAY_IMPORT[package]}:
            found.append(f"{name}: not from {package}")
    return found


def violations_in_subfolder(source: str, package: str, subfolder: str) -> list[str]:
    """Return what is wrong with the imports of a module in a subfolder of a package.

    A subfolder must not import the package itself, whose `__init__` imports the subfolders.
    """
    found = []
    for name in imported(ast.parse(source)):
        first, _, rest = name.partition(".")
        other, _, inside = rest.partition(".")
        target = inside.partition(".")[0]
        if first == "zenvoy" and other == package:
            if target not in SUBFOLDERS[package]:
                found.append(f"{name}: the package as a whole")
            elif target != subfolder and target not in SUBFOLDERS[package][subfolder]:
                found.append(f"{name}: not from {subfolder}")
    return found


MODULES: Final = sorted(path for package in MAY_IMPORT for path in (ROOT / package).rglob("*.py"))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_one_way(path: Path) -> None:
    package = path.relative_to(ROOT).parts[0]
    assert violations(path.read_text(), package, path.stem) == []


IN_SUBFOLDERS: Final = [
    (path.relative_to(ROOT), package, path.relative_to(ROOT / package).parts[0].removesuffix(".py"))
    for path in MODULES
    if (package := path.relative_to(ROOT).parts[0]) in SUBFOLDERS
    and path != ROOT / package / "__init__.py"
]


@pytest.mark.parametrize(("path", "package", "subfolder"), IN_SUBFOLDERS, ids=str)
def test_imports_between_subfolders_point_one_way(path: Path, package: str, subfolder: str) -> None:
    assert subfolder in SUBFOLDERS[package], f"{path}: is in no known subfolder"
    assert violations_in_subfolder((ROOT / path).read_text(), package, subfolder) == []


def test_subfolders_have_no_cycle() -> None:
    for subfolders in SUBFOLDERS.values():
        order = tuple(TopologicalSorter(subfolders).static_order())  # raises CycleError
        assert set(order) == set(subfolders)


def test_every_subfolder_is_installed() -> None:
    """The list of packages in pyproject.toml is written by hand."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {path.parent for name in MAY_IMPORT for path in (ROOT / name).rglob("__init__.py")}
    names = {".".join(("zenvoy", *folder.relative_to(ROOT).parts)) for folder in folders}
    assert set(settings["packages"]) == (names - {"zenvoy.zenvoy"}) | {"zenvoy"}  # the façade


def test_every_package_is_checked() -> None:
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
        ("fleet", "from zenvoy.analysis.summary import summarize"),
        ("fleet", "from zenvoy.cli import exits"),
        ("studies", "from zenvoy.cli.terminal import console"),
        ("studies", "from zenvoy.errors import RunError"),
        ("zenvoy", "from zenvoy.cli import exits"),
        ("zenvoy", "import zenvoy.world.agent"),
        ("studies", "from zenvoy.world.lock_step import LockStepWorld"),
        ("analysis", "from zenvoy.studies.cell import Cell"),
        ("world", "from zenvoy.fleet.agents import agents_of"),
        ("bus", "from zenvoy.scenarios import Scenario"),
        ("scenarios", "from zenvoy.bus import topics"),
        ("scenarios", "from zenvoy.keyed_random.draws import uniforms"),
        ("links", "from zenvoy.scenarios import Scenario"),
        ("links", "from zenvoy.channel.pairs import pairs"),
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
    assert len(violations(source, package, "made_up")) == 1


@pytest.mark.parametrize(
    ("package", "module", "source"),
    [
        ("bus", "clock", "import time"),
        ("fleet", "run", "from zenvoy.world.process import run_world\nimport zenvoy.bus.clock"),
        (
            "world",
            "agent",
            "from zenvoy.world.fleet import Fleet\nfrom zenvoy.keyed_random import draws",
        ),
        ("analysis", "log", "import timeit\nfrom datetime import time\nimport numpy as np"),
    ],
)
def test_a_right_import_is_accepted(package: str, module: str, source: str) -> None:
    assert violations(source, package, module) == []


@pytest.mark.parametrize(
    ("package", "subfolder", "source"),
    [
        ("analysis", "log", "from zenvoy.analysis.page.files import write_whole"),
        ("analysis", "measures", "from zenvoy.analysis.theory import laws"),
        ("analysis", "page", "from zenvoy.analysis import chapters"),
        ("analysis", "chapters", "def late():\n    import zenvoy.analysis.paper.claims"),
        ("analysis", "chapters", "from zenvoy.analysis import load"),
        ("scenarios", "schema", "from zenvoy.scenarios.reading.tree import Node"),
        ("scenarios", "errors", "import zenvoy.scenarios.schema.scenario"),
        ("scenarios", "reading", "from zenvoy.scenarios import Scenario"),
    ],
)
def test_a_wrong_import_between_subfolders_is_found(
    package: str, subfolder: str, source: str
) -> None:
    assert len(violations_in_subfolder(source, package, subfolder)) == 1


@pytest.mark.parametrize(
    ("package", "subfolder", "source"),
    [
        ("analysis", "log", "from zenvoy.analysis.log.records import Reader"),
        ("analysis", "chapters", "from zenvoy.analysis.page import style"),
        ("analysis", "paper", "from zenvoy.scenarios import Scenario\nimport numpy as np"),
        ("scenarios", "reading", "from zenvoy.scenarios.schema.scenario import Scenario"),
    ],
)
def test_a_right_import_between_subfolders_is_accepted(
    package: str, subfolder: str, source: str
) -> None:
    assert violations_in_subfolder(source, package, subfolder) == []
