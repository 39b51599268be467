"""Laws by name: of the library, of an installed package, or of a file beside a scenario.

Code is found in three ways: `name` is a law of the library or an entry point `zenvoy.laws`;
`module:attribute` is a module beside the scenario, or else an installed one; `file.py:attribute`
is a file beside the scenario. A hash of its source is added to the reference, so that a reference
stands for one law and no other: two runs of different sources never look alike.
"""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from importlib.metadata import entry_points, packages_distributions, version
from pathlib import Path
from types import ModuleType
from typing import Final, NamedTuple

from zenvoy.laws.estimator import Estimator
from zenvoy.laws.law import Law
from zenvoy.laws.table import bring, builtin


class Kind(NamedTuple):
    """What is looked for: its record, the group of its entry points, and names that are taken."""

    record: type[Law] | type[Estimator]
    group: str
    taken: Callable[[], Collection[str]]


LAWS: Final = Kind(Law, "zenvoy.laws", builtin)
ESTIMATORS: Final = Kind(Estimator, "zenvoy.estimators", lambda: ("kalman", "ekf", "ukf"))

_LARGEST_BYTES: Final = 16 << 20
_DIGITS: Final = 12  # of the hash: enough to tell sources apart, short enough to be read


class UnknownLawError(Exception):
    """A reference that leads to no law; the text says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A module of laws: what was read, from where, and which version says so."""

    module: ModuleType
    path: Path
    sha256: str
    version: str = ""


def resolve(
    reference: str, folder: Path | None, kind: Kind = LAWS, *, allow_code: bool = False
) -> str:
    """Make what a reference stands for known here, and return the reference with the source's hash.

    `folder` is that of the scenario; without one, only installed code is found. Code elsewhere is
    not run unless `allow_code`. Raises UnknownLawError.
    """
    base, _, digest = reference.partition("#")
    if base in kind.taken():
        return base
    target = base if ":" in base else _entry_point(base, kind)
    module, _, attribute = target.rpartition(":")
    source = _source(module, folder, digest, allow_code=allow_code)
    short = source.sha256[:_DIGITS]
    law = _record_in(source, attribute, kind)
    if law.name in kind.taken():
        raise UnknownLawError(f"its name {law.name} is taken by one of Zenvoy's own")
    full = f"{target}#{short}"
    if isinstance(law, Law) and not law.version:
        law = replace(law, version=source.version)
    bring(full, law)
    return full


def _entry_point(name: str, kind: Kind) -> str:
    found = [point for point in entry_points(group=kind.group) if point.name == name]
    if not found:
        names = [*kind.taken(), *sorted(point.name for point in entry_points(group=kind.group))]
        what = kind.record.__name__.lower()
        allowed = f"{', '.join(names)}, or module:attribute"
        raise UnknownLawError(f"no such {what}; allowed: {allowed}")
    return found[0].value.replace(" ", "")


def _source(module: str, folder: Path | None, digest: str, *, allow_code: bool) -> Source:
    if module.endswith(".py") or (folder and (folder / f"{module}.py").is_file()):
        name = module if module.endswith(".py") else f"{module}.py"
        return _of_file((folder or Path()) / name, folder, digest, allow_code=allow_code)
    return _installed(module, folder, digest, allow_code=allow_code)


def _of_file(path: Path, folder: Path | None, digest: str, *, allow_code: bool) -> Source:
    real = path.resolve()
    inside = folder is not None and real.is_relative_to(folder.resolve())
    if not inside and not allow_code:
        raise UnknownLawError("its file does not lie beside the scenario; --allow-code runs it")
    try:
        if not real.is_file():
            raise UnknownLawError(f"there is no file {path.name}")
        with real.open("rb") as file:
            text = file.read(_LARGEST_BYTES + 1)
    except OSError as error:
        raise UnknownLawError(f"{path.name} cannot be read: {error.strerror}") from error
    if len(text) > _LARGEST_BYTES:
        raise UnknownLawError(f"{path.name} has more than {_LARGEST_BYTES >> 20} MiB")
    _require(digest, text)  # before any of it runs
    return _executed(real, text)


def _require(digest: str, text: bytes) -> None:
    """Raise UnknownLawError where a source is not the one that a reference asks for."""
    short = hashlib.sha256(text).hexdigest()[:_DIGITS]
    if digest and digest != short:
        raise UnknownLawError(f"its source has changed: the hash is {short}, not {digest}")


def _executed(path: Path, text: bytes) -> Source:
    """Run the module once per process: its laws are compared by identity."""
    sha256 = hashlib.sha256(text).hexdigest()
    name = f"zenvoy_laws_{sha256[:_DIGITS]}_{path.stem}"
    if name not in sys.modules:
        module = ModuleType(name)
        module.__file__ = str(path)
        sys.modules[name] = module  # dataclasses look their module up while they are made
        try:
            exec(compile(text, str(path), "exec"), module.__dict__)
        except Exception as error:
            del sys.modules[name]
            raise UnknownLawError(f"{path.name} cannot be run: {_said(error)}") from error
    return Source(module=sys.modules[name], path=path, sha256=sha256)


def _installed(name: str, folder: Path | None, digest: str, *, allow_code: bool) -> Source:
    top = name.partition(".")[0]
    packages = packages_distributions().get(top, [])
    if not packages and not allow_code:
        where = "no folder to look in" if folder is None else f"there is no {name}.py beside it"
        raise UnknownLawError(f"{where}, and no installed package has a module {top}")
    try:
        module = importlib.import_module(name)
    except Exception as error:
        raise UnknownLawError(f"{name} cannot be imported: {_said(error)}") from error
    path = Path(module.__file__ or "")
    text = path.read_bytes() if path.is_file() else b""
    _require(digest, text)
    sha256 = hashlib.sha256(text).hexdigest()
    found = f"{packages[0]} {version(packages[0])}" if packages else ""
    return Source(module=module, path=path, sha256=sha256, version=found)


def _record_in(source: Source, attribute: str, kind: Kind) -> Law | Estimator:
    found: object = source.module
    for part in attribute.split("."):
        found = getattr(found, part, None)
    if isinstance(found, kind.record):
        return found
    name_of = kind.record.__name__
    there = vars(source.module).items()
    laws = sorted(name for name, value in there if isinstance(value, kind.record))
    what = "has no" if found is None else f"has a value that is no {name_of},"
    allowed = f"; allowed: {', '.join(laws)}" if laws else f"; it has no {name_of} at all"
    raise UnknownLawError(f"{source.path.name} {what} {attribute}{allowed}")


def _said(error: Exception) -> str:
    """What an error says, with the line of a file that cannot be compiled or run."""
    line = getattr(error, "lineno", None)
    trace = error.__traceback__
    while trace is not None and line is None:
        if trace.tb_next is None and trace.tb_frame.f_code.co_filename != __file__:
            line = trace.tb_lineno
        trace = trace.tb_next
    said = getattr(error, "msg", None) or str(error)
    return f"{type(error).__name__}: {said}" + (f" (line {line})" if line else "")


def has_entry_point(name: str, kind: Kind = LAWS) -> bool:
    """Return whether an installed package offers one of that name."""
    return any(point.name == name for point in entry_points(group=kind.group))
