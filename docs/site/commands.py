"""What MkDocs adds to docs/: the reference of the command line, made by Typer."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Final

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT: Final = Path(__file__).parents[2]
_SECTION: Final = re.compile(r"^##+ `(zenvoy[^`]*)`\n\n(.*?)\n\n", re.MULTILINE | re.DOTALL)
_ROW: Final = re.compile(r"^\* `([\w-]+)`: .*$", re.MULTILINE)
_USAGE: Final = re.compile(r"^```console\n\$ (.*)\n```$", re.MULTILINE)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the reference."""
    files.append(File.generated(config, "commands.md", content=commands()))
    return files


def commands() -> str:
    """Return the reference as Markdown."""
    arguments = ["zenvoy.cli.app", "utils", "docs", "--name", "zenvoy", "--title", "Commands"]
    made = subprocess.run(
        [sys.executable, "-m", "typer", *arguments],
        check=True,
        capture_output=True,
        encoding="utf-8",
        cwd=ROOT,
    )
    page = made.stdout.replace("* `--help`", "* `-h, --help`")
    # A usage is a pattern and not a command: it has no prompt, and nothing to copy.
    return _with_whole_summaries(_USAGE.sub(r"``` { .text .no-copy }\n\1\n```", page))


def _with_whole_summaries(page: str) -> str:
    """Return the reference with links in its lists of commands, whose summaries Typer cuts."""
    summaries = {name: " ".join(text.split()) for name, text in _SECTION.findall(page)}
    parts = re.split(r"(?=^##+ `)", page, flags=re.MULTILINE)
    return "".join(_listed(part, summaries) for part in parts)


def _listed(part: str, summaries: dict[str, str]) -> str:
    section = _SECTION.match(part)
    group = section[1] if section else "zenvoy"

    def row(found: re.Match[str]) -> str:
        name = f"{group} {found[1]}"
        return f"* [`{found[1]}`](#{name.replace(' ', '-')}): {summaries[name]}"

    before, heading, listed = part.partition("**Commands**:\n")
    return before + heading + _ROW.sub(row, listed)
