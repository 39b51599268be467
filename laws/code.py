"""The code of a law: a file beside a scenario, or a module of an installed package."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import packages_distributions, version
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Final

from zenvoy.laws.errors import UnknownLawError, deepest, described, errors_of_the_code
from zenvoy.laws.private_modules import run_privately
from zenvoy.laws.sources import Sources, sources_of_file, sources_of_module

DIGITS: Final = 12  # of a hash: enough to tell sources apart, and short enough to read
_PRIVATE: Final = re.compile(r"\bzenvoy_laws_\d+\.")

# The code of a law runs once per process and hash of its sources, because laws are compared by
# identity.
_run: Final[dict[tuple[Path, str], ModuleType]] = {}
_imported: Final[dict[str, str]] = {}


class CodeElsewhereError(UnknownLawError):
    """A file is not beside the scenario, and only the user can allow that it is run."""

    def __init__(self) -> None:
        super().__init__("its file is not beside the scenario")


@dataclass(frozen=True, slots=True, kw_only=True)
class Code:
    """A module of laws: the module, its file, its hash, and the version of its package."""

    module: ModuleType
    path: Path
    digest: str
    version: str = ""
    sources: Sources | None = None
    """All modules that were run; None if Python itself found the module."""


def code_of(module: str, folder: Path | None, digest: str, *, allow_code: bool) -> Code:
    """Run the module of a reference, and return it; raises UnknownLawError.

    If `digest` is not "", sources with another hash are refused before they are run.
    """
    if module.endswith(".py") or (folder and (folder / f"{module}.py").is_file()):
        name = module if module.endswith(".py") else f"{module}.py"
        return _of_file((folder or Path()) / name, folder, digest, allow_code=allow_code)
    return _installed(module, folder, digest, allow_code=allow_code)


def _of_file(path: Path, folder: Path | None, digest: str, *, allow_code: bool) -> Code:
    real = path.resolve()
    inside = folder is not None and real.is_relative_to(folder.resolve())
    if not inside and not allow_code:
        raise CodeElsewhereError
    if not real.is_file():
        raise UnknownLawError(f"there is no file {path.name}")
    return code_in(sources_of_file(real), digest)


def code_in(sources: Sources, digest: str) -> Code:
    """Run the first module of the sources, and return it; raises UnknownLawError.

    If `digest` is not "", sources with another hash are refused before they are run.
    """
    real = next(iter(sources.modules.values())).path
    found = _required(digest, sources)
    if (real, found) not in _run:
        with errors_of_the_code(
            lambda error: _failed(f"{real.name} cannot be run", error, sources)
        ):
            _run[real, found] = run_privately(sources)
    return Code(module=_run[real, found], path=real, digest=found, sources=sources)


def _installed(name: str, folder: Path | None, digest: str, *, allow_code: bool) -> Code:
    top = name.partition(".")[0]
    packages = packages_distributions()
    owners = packages.get(top, [])
    if not owners and not allow_code:
        where = "no folder to look in" if folder is None else f"there is no {name}.py beside it"
        raise UnknownLawError(f"{where}, and no installed package has a module {top}")
    sources = _sources(name, top, packages)
    found = _required(digest, sources)
    if _imported.setdefault(name, found) != found:
        raise UnknownLawError(f"the source of {name} has changed since it was imported; start anew")
    with errors_of_the_code(lambda error: _failed(f"{name} cannot be imported", error, sources)):
        module = import_module(name)
    release = f"{owners[0]} {version(owners[0])}" if owners else ""
    path = Path(getattr(module, "__file__", None) or f"{name}.py")
    return Code(module=module, path=path, digest=found, version=release)


def _sources(name: str, top: str, packages: Mapping[str, Sequence[str]]) -> Sources:
    """Return the module and the modules that it imports from its own distribution."""
    try:
        spec = find_spec(top)
    except (ImportError, ValueError):
        spec = None
    if spec is None:
        return Sources(folder=Path(), modules={})
    inside = [Path(place).parent for place in spec.submodule_search_locations or ()]
    owners = packages.get(top, [])
    sources = [
        sources_of_module(name, root, lambda one: packages.get(one, []) == owners)
        for root in inside or [Path(spec.origin or "").parent]
    ]
    return next((one for one in sources if one.modules), sources[0])


def _required(digest: str, sources: Sources) -> str:
    """Return the hash of the sources; raises UnknownLawError if a reference asks for another."""
    found = sources.sha256()[:DIGITS]
    if digest and digest != found:
        raise UnknownLawError(f"its source has changed: the hash is {found}, not {digest}")
    return found


def _failed(what: str, error: BaseException, sources: Sources) -> UnknownLawError:
    """Return the error for code that cannot be run, with the file and the line."""
    files = {str(file.path) for file in sources.modules.values()}
    file, line = deepest(error.__traceback__, files)
    if isinstance(error, SyntaxError) and error.filename in files:
        file, line = error.filename, error.lineno or 0
    place = f" ({Path(file).name}, line {line})" if line else ""
    return UnknownLawError(f"{what}: {_PRIVATE.sub('', described(error))}{place}")
