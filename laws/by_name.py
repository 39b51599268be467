"""Finds laws by name: in the library, in an installed package, or in a file beside a scenario.

A reference takes one of three forms: `name` is a law of the library or an entry point
`zenvoy.laws`; `module:NAME` is in a module beside the scenario, or else in an installed one;
`file.py:NAME` is in a file beside the scenario. A hash of the source, and of the modules
beside it that it imports, is added to the reference, so that runs of different sources have
different references.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Final, NamedTuple

from zenvoy.laws.checks import why_refused
from zenvoy.laws.code import Code, code_of
from zenvoy.laws.errors import UnknownLawError
from zenvoy.laws.estimator import BUILTIN, Estimator
from zenvoy.laws.law import Law
from zenvoy.laws.table import builtin, register


class Kind(NamedTuple):
    """What to look for: the type of record, its group of entry points, and the reserved names.

    `form` shows how to name one's own.
    """

    record: type[Law] | type[Estimator]
    group: str
    taken: Callable[[], Collection[str]]
    form: str


LAWS: Final = Kind(Law, "zenvoy.laws", builtin, "file:NAME such as fvdm:FVDM")
ESTIMATORS: Final = Kind(
    Estimator,
    "zenvoy.estimators",
    lambda: BUILTIN,
    "file:NAME such as constant:CONSTANT",
)


def resolve(
    reference: str, folder: Path | None, kind: Kind = LAWS, *, allow_code: bool = False
) -> str:
    """Load the law of a reference, and return the reference with the hash of the source.

    `folder` is the folder of the scenario; without it, only installed code is found. Code elsewhere
    is not run unless `allow_code`. Raises UnknownLawError.
    """
    base, _, digest = reference.partition("#")
    if base in kind.taken():
        return base
    target = base if ":" in base else _entry_point(base, kind)
    module = target.rpartition(":")[0]
    return registered(code_of(module, folder, digest, allow_code=allow_code), target, kind)


def registered(code: Code, target: str, kind: Kind) -> str:
    """Register the law or estimator that `target` names in a module; return its full reference.

    Raises UnknownLawError.
    """
    name = target.rpartition(":")[2]
    law = _record_in(code, name, kind)
    why = why_refused(law)
    if why is not None:
        raise UnknownLawError(f"{code.path.name}, {name}: {why}")
    if law.name in kind.taken():
        raise UnknownLawError(f"its name {law.name} is already that of one of Zenvoy's own")
    full = f"{target}#{code.digest}"
    if isinstance(law, Law) and not law.version:
        law = replace(law, version=code.version)
    register(full, law, code.sources)
    return full


def _entry_point(name: str, kind: Kind) -> str:
    found = [point for point in entry_points(group=kind.group) if point.name == name]
    if not found:
        names = [*kind.taken(), *sorted(point.name for point in entry_points(group=kind.group))]
        what = kind.record.__name__.lower()
        allowed = f"{', '.join(names)}, or {kind.form}"
        raise UnknownLawError(f"no such {what}; allowed: {allowed}")
    return found[0].value.replace(" ", "")


def _record_in(code: Code, attribute: str, kind: Kind) -> Law | Estimator:
    found: object = code.module
    for part in attribute.split("."):
        found = getattr(found, part, None)
    if isinstance(found, kind.record):
        return found
    name_of = kind.record.__name__
    there = vars(code.module).items()
    laws = sorted(name for name, value in there if isinstance(value, kind.record))
    what = "has no" if found is None else f"has a value that is not of type {name_of},"
    allowed = f"; allowed: {', '.join(laws)}" if laws else f"; it has no {name_of} at all"
    raise UnknownLawError(f"{code.path.name} {what} {attribute}{allowed}")


def has_entry_point(name: str, kind: Kind = LAWS) -> bool:
    """Return whether an installed package has an entry point of that name."""
    return any(point.name == name for point in entry_points(group=kind.group))
