"""The site of the documentation builds without a warning, and needs no internet."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest
from playwright.sync_api import Page, expect

from tests.analysis.view.conftest import chromium
from tests.conftest import LIMIT_S
from tests.page_commands import commands_of_blocks

ROOT: Final = next(folder for folder in Path(__file__).parents if (folder / "Makefile").exists())


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site as `make site` does, into a folder of its own."""
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        check=False,
        cwd=ROOT,
        capture_output=True,
        encoding="utf-8",
        timeout=2 * LIMIT_S,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )
    assert built.returncode == 0, built.stderr
    assert "WARNING" not in built.stderr
    return folder


def test_every_page_is_in_the_site(site: Path) -> None:
    pages = {path.stem for path in ROOT.glob("docs/*.md")} - {"README"}
    made = {"index", "commands", "contributing", "changelog", "benchmarks", "first-steps"}
    assert pages | made <= {path.stem for path in site.glob("*.html")}


def test_pages_load_nothing_from_elsewhere(site: Path) -> None:
    loads = re.compile(
        r'<(?:script|img|link rel="(?:stylesheet|icon)")[^>]*(?:src|href)="(https?:)'
    )
    assert [page.name for page in site.rglob("*.html") if loads.search(page.read_text())] == []


def test_every_command_is_in_the_reference(site: Path) -> None:
    page = (site / "commands.html").read_text()
    for command in ("run", "view", "sweep", "schema", "import"):
        assert f"zenvoy {command}" in page


def test_lists_of_commands_have_whole_summaries_and_links(site: Path) -> None:
    page = (site / "commands.html").read_text()
    row = r'<li><a href="#([\w-]+)"><code>[\w-]+</code></a>: (.*)</li>'
    listed: list[tuple[str, str]] = re.findall(row, page)
    section = r'<h[23] id="(zenvoy-[\w-]+)">.*</h[23]>\n<p>([^<]*)</p>'
    sections: list[tuple[str, str]] = re.findall(section, page)
    assert len(listed) > 30
    assert sorted(listed) == sorted(sections)


def test_the_navigation_has_the_titles_of_the_pages(site: Path) -> None:
    page = (site / "all-pages.html").read_text()
    link = r'<a href="([^"#:]+)" class="md-nav__link">\s*<span class="md-ellipsis">\s*(.*?)\s*<'
    entries: list[tuple[str, str]] = re.findall(link, page)
    assert len(entries) > 40
    assert [entry for entry in entries if entry[1] != title(site / entry[0])] == []
    titles = [text for _, text in entries]
    assert len(set(titles)) == len(titles)


def title(page: Path) -> str:
    found = re.search(r"<h1[^>]*>(.*?)<a class", page.read_text())
    assert found is not None, page
    return re.sub("<[^>]*>", "", found[1])


def test_blocks_of_code_are_found(site: Path) -> None:
    assert [page.name for page in site.rglob("*.html") if "```" in page.read_text()] == []


@pytest.fixture(scope="module")
def browser_page(site: Path) -> Iterator[Page]:
    with chromium() as browser:
        page = browser.new_page()
        page.goto(site.as_uri() + "/index.html")
        yield page


@pytest.mark.parametrize("name", ["tutorial", "several-hosts", "arrays"])
def test_copies_of_consoles_can_be_pasted(site: Path, browser_page: Page, name: str) -> None:
    source = (ROOT / "docs" / f"{name}.md").read_text()
    typed = [list(command.words) for command in commands_of_blocks(source)]
    browser_page.goto(f"{site.as_uri()}/{name}.html")
    copied = copies(browser_page)
    assert "$ " not in "".join(copied)
    lines = [line for copy in copied for line in copy.splitlines()]
    found = [part for line in lines for part in line.split(" && ")]
    assert [words for words in typed if words not in map(split, found)] == []
    consoles = re.findall(r"^```console\n(.*?)^```", source, re.MULTILINE | re.DOTALL)
    shown = [line for text in consoles for line in text.splitlines() if line[:2] != "$ "]
    assert set(shown).isdisjoint(lines)


def split(line: str) -> list[str]:
    try:
        return shlex.split(line, comments=True)
    except ValueError:  # a line of Python
        return []


def copies(page: Page) -> list[str]:
    """Return what each button of a page copies."""
    page.evaluate("document.body.append(document.createElement('textarea'))")
    pasted, found = page.locator("body > textarea"), []
    expect(page.locator("[data-clipboard-target]").first).to_be_attached()
    for button in page.locator("[data-clipboard-target]").all():
        button.dispatch_event("click")
        pasted.fill("")
        pasted.press("Control+V")
        found.append(pasted.input_value())
    return found


def test_a_usage_is_not_for_copying(site: Path, browser_page: Page) -> None:
    browser_page.goto(f"{site.as_uri()}/commands.html")
    expect(browser_page.locator("pre").first).to_have_text("zenvoy [OPTIONS] COMMAND [ARGS]...")
    expect(browser_page.locator("[data-clipboard-target]")).to_have_count(0)


def test_the_notebook_is_shown_and_can_be_downloaded(site: Path) -> None:
    notebook = ROOT / "examples" / "notebooks" / "first-steps.ipynb"
    assert (site / notebook.name).read_text() == notebook.read_text()
    assert 'href="first-steps.html"' in (site / "notebook.html").read_text()
    page = (site / "first-steps.html").read_text()
    cells = json.loads(notebook.read_text())["cells"]
    assert page.count('<div class="highlight">') == [c["cell_type"] for c in cells].count("code")
    assert f'href="{notebook.name}" download' in page
    assert '<span class="filename">timegap.py</span>' in page


def test_diagrams_are_pictures(site: Path) -> None:
    page = (site / "architecture.html").read_text()
    assert page.count('class="diagram"') == 3
    assert "mermaid" not in page


def test_the_gallery_has_every_picture_of_the_documentation() -> None:
    shown = set(re.findall(r"!\[.*\]\((.*\.png)\)", (ROOT / "docs" / "gallery.md").read_text()))
    docs = ROOT / "docs"
    pictures = {path.relative_to(docs).as_posix() for path in docs.rglob("*.png")}
    screens = ("foxglove/", "view/")  # their pages show them
    assert shown == {path for path in pictures if not path.startswith(screens)}
