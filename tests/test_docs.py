"""Links and paths in the documentation exist, and its index has every page."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import pytest

from zenvoy.bus.topics import TOPICS

ROOT: Final = next(folder for folder in Path(__file__).parents if (folder / "Makefile").exists())
PAGES: Final = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(ROOT.glob("docs/*.md"))]
LINK: Final = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
PATH: Final = re.compile(
    r"`((?:analysis|bus|channel|cli|fleet|laws|scenarios|studies|vehicles|world|tests|docs)/"
    r"[\w./*-]*)`"
)
KEYS: Final = {topic.pattern for topic in TOPICS}  # `channel/links` is no folder
# These two name existing files. Other pages may also name files of examples and of the past.
MAPS: Final = [ROOT / "CONTRIBUTING.md", ROOT / "docs" / "architecture.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_have_targets(page: Path) -> None:
    missing = [to for to in LINK.findall(page.read_text()) if not (page.parent / to).exists()]
    assert missing == []


@pytest.mark.parametrize("page", MAPS, ids=lambda page: page.name)
def test_paths_exist(page: Path) -> None:
    paths = [path for path in PATH.findall(page.read_text()) if path not in KEYS]
    assert len(paths) > 10
    assert [path for path in paths if not any(ROOT.glob(path.rstrip("/")))] == []


def test_links_are_named_by_words() -> None:
    """A reader sees a title, or what is there, and not the name of a page's file."""
    named = re.compile(r"\[([^\]]*\.md|docs/[^\]]*)\]\(")
    folders = ("*", "docs/**/*", "examples/**/*", "benchmarks/*")
    texts = [ROOT / "docs" / "scenario.schema.json", *ROOT.glob("examples/notebooks/*.ipynb")]
    texts += {path for folder in folders for path in ROOT.glob(f"{folder}.md")}
    found = {path.name: named.findall(path.read_text()) for path in texts}
    assert len(found) > 40
    assert {name: links for name, links in found.items() if links} == {}


def test_the_index_has_every_page() -> None:
    linked = set(LINK.findall((ROOT / "docs" / "README.md").read_text()))
    pages = {path.name for path in ROOT.glob("docs/*.md")} - {"README.md"}
    assert pages <= linked


def test_nothing_points_to_a_document_outside() -> None:
    """The design is in docs/architecture.md, and nowhere else."""
    files = [path for folder in ROOT.glob("*/py.typed") for path in folder.parent.rglob("*.py")]
    assert [path for path in (*files, *PAGES) if "DESIGN" in path.read_text()] == []
