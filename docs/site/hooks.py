"""What MkDocs adds to docs/: pages from other folders, a notebook, and diagrams.

Pages link to each other as files of the repository, so that they work on a code host. Here the
links to files outside docs/ become links to their pages in the site.
"""

from __future__ import annotations

import hashlib
import json
import posixpath
import re
from pathlib import Path
from typing import Any, Final

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT: Final = Path(__file__).parents[2]
DIAGRAMS: Final = "diagrams"
PAGES: Final = {  # by file in the repository
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "benchmarks/results.md": "benchmarks.md",
    "docs/README.md": "all-pages.md",
    "examples/external_vehicle/README.md": "external-vehicle-examples.md",
    "examples/notebooks/first-steps.ipynb": "first-steps.md",
}
FILES: Final = {"bus/messages.proto": "messages.proto", "LICENSE": "LICENSE"}
_FILE_OF: Final = {page: file for file, page in PAGES.items()}
_LINK: Final = re.compile(r"(?<=\]\()(?![a-z]+:|#)([^)#\s]+)(?=[)#])")
_NAMED: Final = re.compile(r"^```(\w+) ([\w.-]+)$", re.MULTILINE)
_WRITTEN: Final = re.compile(r"%%writefile (.*)\n")  # the first line of a cell
_DIAGRAM: Final = re.compile(r"```mermaid\n(.*?)```\n", re.DOTALL)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what does not lie in docs/."""
    for path, page in {**PAGES, **FILES}.items():
        text = (ROOT / path).read_text(encoding="utf-8")
        if path.endswith(".ipynb"):
            file = posixpath.basename(path)
            files.append(File.generated(config, file, content=text))
            text = notebook(text, file)
        files.append(File.generated(config, page, content=text))
    return files


def notebook(text: str, file: str) -> str:
    """Return a notebook as a page that links to its file."""
    first, *cells = [_cell(cell) for cell in json.loads(text)["cells"]]
    link = f'<a href="{file}" download>Download the notebook</a>'
    return "\n\n".join([first, link, *cells]) + "\n"


def _cell(cell: dict[str, Any]) -> str:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        return source
    name = _WRITTEN.match(source)
    title = f" {name[1]}" if name else ""
    return f"```python{title}\n{_WRITTEN.sub('', source)}\n```"


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Point links into the site, name blocks of code, and put pictures in place of diagrams."""
    here = page.file.src_uri
    markdown = _LINK.sub(lambda link: in_site(link[1], here), markdown)
    markdown = _NAMED.sub(r'```\1 title="\2"', markdown)
    return _DIAGRAM.sub(lambda source: _picture(source[1], here), markdown)


def in_site(link: str, page: str) -> str:
    """Return a link of a page, relative to its file in the repository, as one in the site."""
    file = _FILE_OF.get(page, f"docs/{page}")
    target = posixpath.normpath(posixpath.join(posixpath.dirname(file), link))
    found = {**PAGES, **FILES}.get(target, target.removeprefix("docs/"))
    if link.endswith("/") or (ROOT / target).is_dir():
        found = f"{found}/README.md"
    return posixpath.relpath(found, posixpath.dirname(page) or ".")


def diagram_of(source: str) -> str:
    """Return the name of the picture of a diagram, which changes with its source."""
    return hashlib.sha256(source.encode()).hexdigest()[:12] + ".svg"


def _picture(source: str, page: str) -> str:
    name = diagram_of(source)
    if not (ROOT / "docs" / DIAGRAMS / name).exists():
        raise PluginError(f"{page}: a diagram has no picture {DIAGRAMS}/{name}; run make diagrams")
    path = posixpath.relpath(f"{DIAGRAMS}/{name}", posixpath.dirname(page) or ".")
    words = "sequence of messages" if source.startswith("sequence") else "arrows between parts"
    return f'![Diagram: {words}]({path}){{ class="diagram" }}\n'
