"""Scenarios by name or by path, with changes."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from os import PathLike, fspath
from typing import Any, Final

from zenvoy import errors
from zenvoy.scenarios import PYTHON, Loaded, ScenarioError, load

__all__ = ["Loaded", "scenario"]

# `zenvoy.run` also reads scenarios, and has no such argument.
_SPELLING: Final = PYTHON._replace(allow_code="allow_code=True of zenvoy.scenario")


def scenario(
    name_or_path: str | PathLike[str], *, allow_code: bool = False, **changes: Any
) -> Loaded:
    """Return the scenario in a file, or else the built-in one of that name, with changes.

    Each change is a key of the scenario and its value. A mapping changes the keys that it names and
    leaves the others: `channel={"loss": {"p": 0.3}}`, or in short `**{"channel.loss.p": 0.3}`. A
    list replaces the whole list. The result has a `name`, the `scenario` with all its values, and
    `notes` on settings that are allowed but probably a mistake. Your own laws and estimators must
    lie beside the scenario or in an installed package; with `allow_code` they may lie anywhere.
    Raises ScenarioError.
    """
    return loaded(name_or_path, changes, allow_code=allow_code)


def loaded(
    name_or_path: str | PathLike[str],
    changes: Mapping[str, Any],
    seed: int | None = None,
    *,
    allow_code: bool = False,
) -> Loaded:
    """Return the scenario with changes and, if given, another seed."""
    overrides = [f"{key}={_yaml(key, value)}" for key, value in _flat(changes)]
    try:
        return load(
            fspath(name_or_path), overrides, seed=seed, allow_code=allow_code, spelling=_SPELLING
        )
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
    """Return a value as YAML in one line: as JSON, except for infinity and NaN."""
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
    raise errors.ScenarioError(f"{key}: a value of type {type(value).__name__} is not allowed")
