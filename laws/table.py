"""The laws by name: those of the library, and those that a scenario has loaded."""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any

from zenvoy.laws import library
from zenvoy.laws.estimator import Estimator
from zenvoy.laws.law import Law
from zenvoy.laws.sources import Sources

_registered: dict[str, Law | Estimator] = {}
_sources: dict[str, Sources] = {}


@cache
def builtin() -> Mapping[str, Law]:
    """Return the laws that come with Zenvoy, by name, in order of their modes."""
    names = [module.name for module in pkgutil.iter_modules(library.__path__)]
    laws: list[Law] = [import_module(f"{library.__name__}.{name}").LAW for name in names]
    laws.sort(key=lambda law: (law.mode is None, law.mode or 0, law.name))
    return MappingProxyType({law.name: law for law in laws})


def register(reference: str, law: Law | Estimator, sources: Sources | None = None) -> None:
    """Register a law or an estimator by its reference, here and in forked processes.

    `sources` are the modules that were run, unless Python itself found the module.
    """
    _registered[reference] = law
    if sources is not None:
        _sources[reference] = sources


def find(reference: str) -> Law | None:
    """Return the law of a name or reference; None if it is not registered here."""
    law = builtin().get(reference) or _registered.get(reference)
    return law if isinstance(law, Law) else None


def law_of(reference: str) -> Law:
    """Return the law of a registered reference; raises KeyError for others."""
    law = find(reference)
    if law is None:
        raise KeyError(reference)
    return law


def estimator_of(reference: str) -> Estimator:
    """Return the estimator of a registered reference; raises KeyError for others."""
    estimator = _registered.get(reference)
    if not isinstance(estimator, Estimator):
        raise KeyError(reference)
    return estimator


def sources_of(reference: str) -> Sources | None:
    """Return the sources of a registered law or estimator; None if Python found its module."""
    return _sources.get(reference)


def parameters_from(law: Law, section: object) -> Any:
    """Return the parameters of a law, read by name from an object that has them."""
    names = [one.name for one in fields(law.parameters)]
    return law.parameters(**{name: getattr(section, name) for name in names})
