"""Where scenarios and what they refer to are found: as files, or inside the package."""

from __future__ import annotations

import os
import zlib
from dataclasses import dataclass
from importlib.resources.abc import Traversable
from pathlib import Path, PurePosixPath
from typing import Final

from zenvoy.scenarios.errors import Place, Problem, UnknownScenarioError, UnreadableScenarioError
from zenvoy.scenarios.explain import nearest
from zenvoy.scenarios.library import inside, packaged
from zenvoy.scenarios.wording import shown

_MOST_BYTES: Final = 16 << 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Origin:
    """A text that can be read: what it is called, and how messages call its source."""

    name: str
    source: str
    entry: Path | Traversable
    builtin: bool

    @property
    def identity(self) -> tuple[bool, str]:
        """Equal for two origins of the same text."""
        return self.builtin, self.name if self.builtin else os.path.realpath(self.source)

    def text(self, rank: int = 0) -> str:
        """Its contents, unpacked if its name ends in .gz.

        `rank` is that of the places in it. Raises OSError, ValueError where it cannot be unpacked,
        or UnreadableScenarioError where it is not UTF-8.
        """
        data = self.entry.read_bytes()
        if self.entry.name.endswith(".gz"):
            data = _unpacked(data)
        try:
            return data.decode()
        except UnicodeDecodeError as error:
            line = data.count(b"\n", 0, error.start) + 1
            place = Place(source=self.source, line=line, rank=rank)
            text = f"not UTF-8: byte 0x{data[error.start]:02x}"
            raise UnreadableScenarioError([Problem(key="", text=text, place=place)]) from None

    def beside(self, reference: str) -> Origin:
        """The file that this one refers to, whether it exists or not."""
        if not self.builtin:
            return from_here(Path(self.source).parent / reference)
        path = PurePosixPath(self.name).parent / reference
        source = f"built-in {path}"
        return Origin(name=path.stem, source=source, entry=inside(path), builtin=True)

    def base(self, reference: str, place: Place) -> Origin:
        """The scenario that this one extends, as it says at `place`.

        A file beside it, else a built-in one. Raises UnknownScenarioError.
        """
        if not self.builtin and _is_file(path := Path(self.source).parent / reference):
            return from_here(path)
        return _named(reference, "extends", place, files=not self.builtin)


def located(name_or_path: str | Path) -> Origin:
    """The scenario in an existing file, else the built-in one. Raises UnknownScenarioError."""
    if _is_file(name_or_path):
        return from_here(name_or_path)
    return _named(str(name_or_path), "", None, files=True)


def from_here(path: str | Path) -> Origin:
    """The file at a path from the folder of the command, whether it exists or not."""
    entry = Path(path)
    return Origin(name=entry.stem, source=str(path), entry=entry, builtin=False)


def _unpacked(data: bytes) -> bytes:
    """What is in a gzip file; not more than is allowed, however small the file is."""
    text = b""
    while data:  # a file may have several parts
        unpacker = zlib.decompressobj(wbits=16 + zlib.MAX_WBITS)
        try:
            text += unpacker.decompress(data, _MOST_BYTES + 1 - len(text))
        except zlib.error:
            raise ValueError("not a file of gzip") from None
        if len(text) > _MOST_BYTES:
            raise ValueError(f"more than {_MOST_BYTES >> 20} MiB, the most that are allowed")
        if not unpacker.eof:
            raise ValueError("its end is missing")
        data = unpacker.unused_data
    return text


def _is_file(path: str | Path) -> bool:
    # os.path, unlike Path, answers False to names that no file can have.
    return os.path.exists(path) and not os.path.isdir(path)


def _named(name: str, key: str, place: Place | None, *, files: bool) -> Origin:
    known = packaged()
    if name in known:
        return Origin(name=name, source=f"built-in {name}", entry=known[name], builtin=True)
    names = list(known)
    what = "is neither a file nor a built-in scenario" if files else "is no built-in scenario"
    text = f"{shown(name)} {what}; {nearest(name, names)}built-in: {', '.join(names)}"
    raise UnknownScenarioError([Problem(key=key, text=text, place=place)])
