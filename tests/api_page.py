"""`make docs` makes docs/api.md from the docstrings of `import zenvoy`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from griffe import Attribute, GriffeLoader, Object, Parser
from griffe2md import ConfigDict, render_object_docs

ROOT: Final = Path(__file__).parents[1]
PAGE: Final = ROOT / "docs" / "api.md"
_CONFIG: Final[ConfigDict] = {
    "annotations_path": "source",  # so that the base of zenvoy.Run is called analysis.Run
    "docstring_style": "google",
    "filters": ["!^_[^_]", "!^__init__$"],
    "heading_level": 2,
    "inherited_members": True,
    "line_length": 100,
    "merge_init_into_class": False,
    "separate_signature": True,
    "show_if_no_docstring": False,
    "show_root_full_path": True,
    "show_root_heading": True,
    "show_signature_annotations": True,
    "signature_crossrefs": False,
    "summary": False,
}
_HEAD: Final = """# From Python

<!-- Made by `make docs` from the docstrings; not to be edited. -->
"""


# Public name, the folder that defines it, and its place in the folder.
_PARTS: Final = (
    ("zenvoy.run", "zenvoy", "running.run"),
    ("zenvoy.scenario", "zenvoy", "settings.scenario"),
    ("zenvoy.load", "zenvoy", "result.load"),
    ("zenvoy.Run", "zenvoy", "result.Run"),
    ("zenvoy.analysis.Run", "analysis", "log.load.Run"),
    ("zenvoy.Progress", "fleet", "progress.Progress"),
    ("zenvoy.Loaded", "scenarios", "reading.loader.Loaded"),
    ("zenvoy.ZenvoyError", "zenvoy", "errors.ZenvoyError"),
    ("zenvoy.InputError", "zenvoy", "errors.InputError"),
    ("zenvoy.ScenarioError", "zenvoy", "errors.ScenarioError"),
    ("zenvoy.FolderError", "zenvoy", "errors.FolderError"),
    ("zenvoy.LogError", "zenvoy", "errors.LogError"),
    ("zenvoy.RunError", "zenvoy", "errors.RunError"),
    ("zenvoy.ProcessLostError", "zenvoy", "errors.ProcessLostError"),
)
NAMES: Final = tuple(public for public, _, _ in _PARTS)
_LINK: Final = re.compile(r"\[([^\[\]]*)\]\(#[^()]*\)")


def page() -> str:
    """Return the page as it should be."""
    loader = GriffeLoader(search_paths=[ROOT], docstring_parser=Parser.google)
    packages = {folder: loader.load(folder) for folder in {folder for _, folder, _ in _PARTS}}
    intro = packages["zenvoy"].docstring
    assert intro is not None
    text = [_HEAD, intro.value, ""]
    for public, folder, place in _PARTS:
        part = packages[folder][place]
        text.append(_rendered(part).replace(part.path, public))
    return _LINK.sub(r"\1", "\n".join(text))  # half of the anchors would have no target


def _rendered(part: Object) -> str:
    for member in part.all_members.values():
        if isinstance(member, Attribute) and str(member.value) == member.name:
            member.value = None  # `self.log = log` says nothing about the attribute
    return str(render_object_docs(part, _CONFIG, format_md=True))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
