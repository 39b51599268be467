"""The source of a law: its own module, and every module beside it that it imports, at any depth.

The imports are read from the text before any of it runs. So the hash is known before the code runs,
it covers what a function imports later, and it does not depend on earlier imports.
"""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Final, NamedTuple

from zenvoy.laws.errors import UnknownLawError

_LARGEST_BYTES: Final = 16 << 20
_NEVER_BESIDE: Final = sys.stdlib_module_names | {"zenvoy"}


class File(NamedTuple):
    """A module: the file that holds it, and the bytes that were read."""

    path: Path
    text: bytes

    @property
    def is_package(self) -> bool:
        """Whether other modules may lie inside it."""
        return self.path.name == "__init__.py"


@dataclass(frozen=True, slots=True, kw_only=True)
class Sources:
    """Modules of one folder by their dotted names, the module of the law first."""

    folder: Path
    modules: Mapping[str, File]

    def sha256(self) -> str:
        """Return the hash over all files: that of the output of `sha256sum`, in order of path."""
        named = ((file.path.relative_to(self.folder).as_posix(), file) for file in self.files())
        lines = (f"{hashlib.sha256(file.text).hexdigest()}  {name}\n" for name, file in named)
        return hashlib.sha256("".join(lines).encode(errors="surrogateescape")).hexdigest()

    def files(self) -> list[File]:
        """Return the files in order of their paths inside the folder."""
        return sorted(self.modules.values(), key=lambda file: file.path.relative_to(self.folder))


def sources_of_file(path: Path) -> Sources:
    """Return the source of a law in a file; raises UnknownLawError.

    Modules beside it are found by name. The standard library and Zenvoy come before them.
    """
    name = path.stem.replace(".", "_")
    return _collected(name, read(path), path.parent, lambda _: True, ())


def sources_of_module(name: str, folder: Path, belongs: Callable[[str], bool]) -> Sources:
    """Return the source of an importable module below `folder`; raises UnknownLawError.

    It covers the modules of the folder whose top-level name `belongs`; they may be compiled.
    """
    path = _file_of(name, folder, EXTENSION_SUFFIXES)
    if path is None:
        return Sources(folder=folder, modules={})
    return _collected(name, read(path), folder, belongs, EXTENSION_SUFFIXES)


def read(path: Path) -> File:
    """Return a file with its bytes; raises UnknownLawError."""
    try:
        with path.open("rb") as file:
            text = file.read(_LARGEST_BYTES + 1)
    except OSError as error:
        raise UnknownLawError(f"{path.name} cannot be read: {error.strerror}") from error
    if len(text) > _LARGEST_BYTES:
        raise UnknownLawError(f"{path.name} has more than {_LARGEST_BYTES >> 20} MiB")
    return File(path, text)


def _collected(
    name: str,
    first: File,
    folder: Path,
    belongs: Callable[[str], bool],
    compiled: Sequence[str],
) -> Sources:
    found = {name: first}
    waiting = [*_parents(name), *_imports(name, first)]
    while waiting:
        wanted = waiting.pop()
        top = wanted.partition(".")[0]
        if wanted in found or top in _NEVER_BESIDE or not belongs(top):
            continue
        path = _file_of(wanted, folder, compiled)
        if path is not None:
            found[wanted] = read(path)
            waiting += [*_parents(wanted), *_imports(wanted, found[wanted])]
    return Sources(folder=folder, modules=found)


def _file_of(name: str, folder: Path, compiled: Sequence[str]) -> Path | None:
    *parents, last = name.split(".")
    place = folder.joinpath(*parents)
    files = (f"{last}/__init__.py", f"{last}.py", *(last + suffix for suffix in compiled))
    return next((place / file for file in files if (place / file).is_file()), None)


def _parents(name: str) -> Iterator[str]:
    """Yield the packages around a module, which Python imports before it."""
    while name := name.rpartition(".")[0]:
        yield name


def _imports(name: str, file: File) -> Iterator[str]:
    """Yield the names of everything that a module may import, anywhere in its text."""
    if file.path.suffix != ".py":
        return
    try:
        tree = ast.parse(file.text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return  # such a module does not run either, and Python says why
    package = name if file.is_package else name.rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(node, package)
            if base:
                yield base
            yield from (f"{base}.{alias.name}".lstrip(".") for alias in node.names)


def _absolute(node: ast.ImportFrom, package: str) -> str:
    """Return the absolute name of what `from` names; "" for the folder itself."""
    if not node.level:
        return node.module or ""
    around = package.split(".") if package else []
    around = around[: max(0, len(around) - node.level + 1)]
    return ".".join([*around, *filter(None, [node.module])])
