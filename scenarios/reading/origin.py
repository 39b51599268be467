"""Finds scenarios and the files that they name, on disk or inside the package."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path, PurePosixPath
from typing import Final, Protocol

from zenvoy.scenarios.errors import Place, Problem, UnknownScenarioError, UnreadableScenarioError
from zenvoy.scenarios.reading.bounded import (
    LARGEST_BYTES,
    STANDARD_INPUT,
    RegularFile,
    StandardInput,
)
from zenvoy.scenarios.reading.explain import nearest
from zenvoy.scenarios.reading.library import inside, packaged
from zenvoy.values.wording import shown

_LONGEST_NAME: Final = 100  # the search for similar names takes longer for longer names
_MOST_NEIGHBOURS: Final = 1_000
_MOST_PARTS: Final = 1_000


class Readable(Protocol):
    """A file, a file inside the package, or standard input."""

    def read_bytes(self) -> bytes:
        """Return the contents; raises OSError."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """A text to read: its name, and the name of its source in messages."""

    name: str
    source: str
    entry: Readable
    builtin: bool

    @property
    def identity(self) -> tuple[bool, str]:
        """A value that is equal for two origins of the same text."""
        return self.builtin, self.name if self.builtin else os.path.realpath(self.source)

    def text(self, rank: int = 0) -> str:
        """Return the contents, unpacked if the name ends in .gz.

        `rank` is that of the places in it. Raises OSError, ValueError if it cannot be unpacked, or
        UnreadableScenarioError if it is not UTF-8.
        """
        data = self.entry.read_bytes()
        if self.source.endswith(".gz"):
            data = _unpacked(data)
        try:
            return data.decode()
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            place = Place(source=self.source, line=line, rank=rank)
            text = f"not UTF-8: byte 0x{data[error.start]:02x}"
            raise UnreadableScenarioError([Problem(key="", text=text, place=place)]) from None

    def beside(self, reference: str) -> Origin:
        """Return the file that this one refers to; it need not exist."""
        if not self.builtin:
            return from_here(Path(self.source).parent / reference)
        path = PurePosixPath(self.name).parent / reference
        source = f"built-in {path}"
        return Origin(name=path.stem, source=source, entry=inside(path), builtin=True)

    def base(self, reference: str, place: Place) -> Origin:
        """Return the scenario that this one extends at `place`.

        It is a file beside this one, or else a built-in scenario. Raises UnknownScenarioError.
        """
        if not self.builtin and _is_file(path := Path(self.source).parent / reference):
            return from_here(path)
        return _named(reference, "extends", place, files=not self.builtin)


def located(name_or_path: str | Path) -> Origin:
    """Return the scenario in an existing file, else the built-in one; "-" is standard input.

    Raises UnknownScenarioError.
    """
    if str(name_or_path) == STANDARD_INPUT:
        source = "standard input"
        return Origin(name="stdin", source=source, entry=StandardInput(), builtin=False)
    if _is_file(name_or_path):
        return from_here(name_or_path)
    return _named(str(name_or_path), "", None, files=True)


def from_here(path: str | Path) -> Origin:
    """Return the file at a path relative to the current folder; it need not exist."""
    entry = RegularFile(str(path))
    return Origin(name=Path(path).stem, source=str(path), entry=entry, builtin=False)


def origin_of(reference: str, place: Place, origins: Mapping[str, Origin]) -> Origin:
    """Return the file that a value at `place` names; it need not exist.

    The name is relative to the file that contains it, which `origins` finds by the `source` of the
    place. In an option, it is relative to the current folder.
    """
    origin = origins.get(place.source)
    return from_here(reference) if origin is None else origin.beside(reference)


def _unpacked(data: bytes) -> bytes:
    """Unpack a gzip file; raises ValueError if the result exceeds the limit."""
    text = b""
    parts = 0
    while data:  # a file may have several parts
        parts += 1
        if parts > _MOST_PARTS:
            raise ValueError(f"more than {_MOST_PARTS} gzip members")
        unpacker = zlib.decompressobj(wbits=16 + zlib.MAX_WBITS)
        try:
            text += unpacker.decompress(data, LARGEST_BYTES + 1 - len(text))
        except zlib.error:
            raise ValueError("not a gzip file") from None
        if len(text) > LARGEST_BYTES:
            raise ValueError(f"larger than the limit of {LARGEST_BYTES >> 20} MiB")
        if not unpacker.eof:
            raise ValueError("its end is missing")
        data = unpacker.unused_data
    return text


def _is_file(path: str | Path) -> bool:
    # os.path, unlike Path, returns False for invalid file names.
    return os.path.exists(path) and not os.path.isdir(path)


def _named(name: str, key: str, place: Place | None, *, files: bool) -> Origin:
    known = packaged()
    if name in known:
        return Origin(name=name, source=f"built-in {name}", entry=known[name], builtin=True)
    what = "is neither a file nor a built-in scenario" if files else "is not a built-in scenario"
    # The author of a scenario must not learn which files lie beside a scenario that it extends.
    hint = nearest(name[:_LONGEST_NAME], _alike(known, _beside(name) if not key else ()))
    text = f"{shown(name)} {what}; {hint}built-in: {', '.join(known)}"
    raise UnknownScenarioError([Problem(key=key, text=text, place=place)])


def _alike(builtin: Iterable[str], beside: Iterable[str]) -> dict[str, str]:
    """Return likely spellings of scenarios, such as without folder or suffix, and their names."""
    builtin = list(builtin)
    names = {name.rpartition("/")[2]: name for name in reversed(builtin)}
    names |= {f"{name}{suffix}": name for name in builtin for suffix in (".yaml", "")}
    return names | {called: path for path in beside for called in (path, os.path.splitext(path)[0])}


def _beside(path: str) -> list[str]:
    """Return the scenario files in the folder of `path`, which itself does not exist."""
    folder = os.path.dirname(path)
    try:
        with os.scandir(folder or ".") as entries:
            names = sorted(entry.name for entry in islice(entries, _MOST_NEIGHBOURS))
    except (OSError, ValueError):
        return []
    return [os.path.join(folder, name) for name in names if name.endswith((".yaml", ".yml"))]
