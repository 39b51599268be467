"""The scenarios that come with the package."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import PurePath

from zenvoy.scenarios.schema.technologies import RADIOS

_SUFFIX = ".yaml"


def packaged() -> dict[str, Traversable]:
    """The YAML files inside the package by name ("paper/case-15"), case-2 before case-15."""
    found = dict(_under(files("zenvoy.scenarios"), ""))
    return dict(sorted(found.items(), key=lambda item: _natural(item[0])))


def inside(path: PurePath) -> Traversable:
    """The file inside the package at a relative path, whether it exists or not."""
    return files("zenvoy.scenarios").joinpath(*path.parts)


def _under(folder: Traversable, prefix: str) -> Iterator[tuple[str, Traversable]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            if entry.name != RADIOS:  # technologies are no scenarios
                yield from _under(entry, f"{prefix}{entry.name}/")
        elif entry.name.endswith(_SUFFIX):
            yield f"{prefix}{entry.name.removesuffix(_SUFFIX)}", entry


def _natural(name: str) -> list[str | int]:
    # Splitting at a group of digits gives text and digits in turn, so like meets like.
    return [int(part) if part.isdecimal() else part for part in re.split(r"(\d+)", name)]
