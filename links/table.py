"""The loss models and the distributions of latency that come with Zenvoy, by name."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType, ModuleType

from zenvoy.keyed_random.draws import Purpose
from zenvoy.links import latency, loss
from zenvoy.links.distribution import Distribution
from zenvoy.links.loss_model import LossModel


@cache
def loss_models() -> Mapping[str, LossModel]:
    """Return the loss models, by the key of `channel.loss`, in order of the keys.

    Raises ValueError if two of them would draw the same numbers.
    """
    models: list[LossModel] = [module.LOSS for module in _modules(loss)]
    taken = {int(purpose): purpose.name for purpose in Purpose}
    for model in models:
        other = taken.setdefault(model.number, model.key)
        if other != model.key:
            raise ValueError(f"loss model {model.key}: {other} has purpose {model.number}, too")
    models.sort(key=lambda model: (model.place is None, model.place or 0, model.key))
    return MappingProxyType({model.key: model for model in models})


@cache
def distributions() -> Mapping[str, Distribution]:
    """Return the distributions of latency, by name, in order of the names in messages."""
    found: list[Distribution] = [module.LATENCY for module in _modules(latency)]
    found.sort(key=lambda one: (one.place is None, one.place or 0, one.name))
    return MappingProxyType({one.name: one for one in found})


def _modules(package: ModuleType) -> Iterator[ModuleType]:
    names = [module.name for module in pkgutil.iter_modules(package.__path__)]
    return (import_module(f"{package.__name__}.{name}") for name in names)
