"""Scenarios by name or by path, with changes."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from os import PathLike, fspath
from typing import Any

from zenvoy import errors
from zenvoy.scenarios import Loaded, ScenarioError, load

__all__ = ["Loaded", "scenario"]


def scenario(
    name_or_path: str | PathLike[str], *, allow_code: bool = False, **changes: Any
) -> Loaded:
    """Return the scenario in a file, or else the built-in one of that name, with changes.

    Each change is a key of the scenario and its value. Mappings change what they name and leave the
    rest: `channel={"loss": {"p": 0.3}}`, or in short `**{"channel.loss.p": 0.3}`. Lists replace
    lists. The result holds `name`, `scenario` with all its values, and `notes` on what is allowed
    and hardly meant. A law or an estimator of one's own is run if it lies beside the scenario or in
    an installed package; with `allow_code` from anywhere. Raises ScenarioError.
    """
    return loaded(name_or_path, changes, allow_code=allow_code)


def loaded(
    name_or_path: str | PathLike[str],
    changes: Mapping[str, Any],
    seed: int | None = None,
    *,
    allow_code: bool = False,
) -> Loaded:
    """Return the scenario with changes and, where it is given, another seed."""
    overrides = [f"{key}={_yaml(key, value)}" for key, value in _flat(changes)]
    try:
        return load(fspath(name_or_path), overrides, seed=seed, allow_code=allow_code)
    except ScenarioError as error:
        raise errors.ScenarioError(str(error)) from error


def _flat(changes: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in changes.items():
        key = f"{before}{name}"
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{key}.")
        else:
            yield key, value


def _yaml(key: str, value: object) -> str:
    """Return a value as YAML in one line, of which JSON is a part but for numbers not finite."""
    value = _plain(key, value)
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else f"{'-' if value < 0 else ''}.inf"
    return json.dumps(value, ensure_ascii=False)


def _plain(key: str, value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(name): _plain(key, inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(key, inner) for inner in value]
    if isinstance(value, PathLike):
        return fspath(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if hasattr(value, "tolist"):  # numpy's arrays and numbers
        return value.tolist()
    raise errors.ScenarioError(f"{key}: {type(value).__name__} is no type of a scenario's values")
