"""The built-in scenarios."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import PurePath

from zenvoy.scenarios.schema.technologies import RADIOS

_SUFFIX = ".yaml"


def packaged() -> dict[str, Traversable]:
    """Return the scenario files of the package by name ("paper/case-15"), in natural order."""
    found = dict(_under(files("zenvoy.scenarios"), ""))
    return dict(sorted(found.items(), key=lambda item: _natural(item[0])))


def inside(path: PurePath) -> Traversable:
    """Return the file at a relative path inside the package; it need not exist."""
    return files("zenvoy.scenarios").joinpath(*path.parts)


def _under(folder: Traversable, prefix: str) -> Iterator[tuple[str, Traversable]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            if entry.name != RADIOS:  # its files are technologies
                yield from _under(entry, f"{prefix}{entry.name}/")
        elif entry.name.endswith(_SUFFIX):
            yield f"{prefix}{entry.name.removesuffix(_SUFFIX)}", entry


def _natural(name: str) -> list[str | int]:
    # The split gives text and digits in turn, so that text is compared with text only.
    return [int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", name)]
