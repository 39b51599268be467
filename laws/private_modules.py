"""Modules beside a law belong to that law alone: two folders may each have a `gains.py`.

The modules of one law form a package with a unique name. An `import` in them finds the others by
their plain names, whether it runs at once or later in a function. Nothing is added to `sys.path`,
and nothing stays in `sys.modules` under a plain name.
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from itertools import count
from types import ModuleType
from typing import Any, Final

from zenvoy.laws.sources import Sources

_numbers: Final = count(1)


class _Package(Loader):
    """The modules of one law, which run from the bytes that were read."""

    def __init__(self, name: str, sources: Sources) -> None:
        self.name = name
        self._modules = sources.modules
        self._tops = {module.partition(".")[0] for module in self._modules}
        self._builtins = vars(builtins) | {"__import__": self._import}

    def spec(self, full: str) -> ModuleSpec | None:
        name = full.partition(".")[2]
        file = self._modules.get(name)
        if file is not None:
            inside: list[str] | None = [] if file.is_package else None
            return spec_from_file_location(
                full, file.path, loader=self, submodule_search_locations=inside
            )
        if not name or any(module.startswith(f"{name}.") for module in self._modules):
            return ModuleSpec(full, self, is_package=True)  # a folder without an __init__.py
        return None

    def exec_module(self, module: ModuleType) -> None:
        file = self._modules.get(module.__name__.partition(".")[2])
        if file is not None:
            module.__dict__["__builtins__"] = self._builtins
            exec(compile(file.text, str(file.path), "exec", dont_inherit=True), module.__dict__)

    def _import(
        self,
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> Any:
        """Import as `__import__` does, but also find modules of this package by plain names."""
        top = name.partition(".")[0]
        if level or top not in self._tops:
            return builtins.__import__(name, globals, locals, fromlist or (), level)
        module = import_module(f"{self.name}.{name}")
        if fromlist:
            return builtins.__import__(module.__name__, globals, locals, fromlist)
        return sys.modules[f"{self.name}.{top}"]


class _Finder(MetaPathFinder):
    """Finds the packages of laws by their names."""

    def __init__(self) -> None:
        self.packages: dict[str, _Package] = {}

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package = self.packages.get(fullname.partition(".")[0])
        return None if package is None else package.spec(fullname)


_FINDER: Final = _Finder()


def run_privately(sources: Sources) -> ModuleType:
    """Run the first module of the sources and all that it imports; raises whatever they raise."""
    if _FINDER not in sys.meta_path:
        sys.meta_path.append(_FINDER)
    name = f"zenvoy_laws_{next(_numbers)}"
    _FINDER.packages[name] = _Package(name, sources)
    try:
        return import_module(f"{name}.{next(iter(sources.modules))}")
    except BaseException:
        del _FINDER.packages[name]
        for module in [one for one in sys.modules if one.partition(".")[0] == name]:
            del sys.modules[module]
        raise
