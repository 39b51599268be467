"""The settings of a study: other changes of its scenario, which all its runs share."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from zenvoy.scenarios import Problem
from zenvoy.scenarios.reading.tree import Node


def settings_problems(
    settings: list[str] | dict[str, Any], varied: Iterable[str], what: str, root: Node
) -> Iterator[Problem]:
    """Yield a problem for each setting that the study also varies, as `what`: "an axis"."""
    of_settings = {setting.partition("=")[0].strip() for setting in as_settings(settings)}
    for key in sorted(of_settings.intersection(varied)):
        place = root.place_of(("settings",))
        yield Problem(key="settings", text=f"{key} is {what} of the study too", place=place)


def as_settings(settings: list[str] | dict[str, Any]) -> list[str]:
    """Return the settings of a study as KEY=VALUE, however they are written."""
    if isinstance(settings, list):
        return settings
    return [setting_of(key, value) for key, value in _flat(settings)]


def _flat(settings: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in settings.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", value


def setting_of(key: str, value: object) -> str:
    """Return a setting as on the command line: KEY=VALUE, with a value in JSON, which is YAML."""
    if isinstance(value, float) and not math.isfinite(value):
        return f"{key}={'.nan' if math.isnan(value) else '-.inf' if value < 0 else '.inf'}"
    return f"{key}={json.dumps(value, ensure_ascii=False)}"
