"""The built-in technologies: the columns of the paper's Table I."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Final

from ruamel.yaml import YAML

from zenvoy.scenarios.schema.technology import Technology

RADIOS: Final = "radios"
"""The folder of their YAML files, inside the package."""

DEFAULT: Final = "ieee80211p"
_SUFFIX: Final = ".yaml"


@cache
def technologies() -> Mapping[str, Technology]:
    """Return the built-in technologies by name, in order of bit rate as in Table I."""
    entries = files("zenvoy.scenarios").joinpath(RADIOS).iterdir()
    found = [_packaged(entry.name.removesuffix(_SUFFIX)) for entry in entries]
    return {each.name: each for each in sorted(found, key=lambda each: each.bit_rate_mbps)}


def default_technology() -> Technology:
    """Return the technology of a scenario that names none."""
    return _packaged(DEFAULT)


def technology_named(value: object) -> object:
    """Return the built-in technology of that name; raises ValueError for any other text.

    Other values are returned as they are, for the schema to check.
    """
    if not isinstance(value, str):
        return value
    if value not in technologies():
        raise ValueError
    return technologies()[value]


@cache
def _packaged(name: str) -> Technology:
    text = files("zenvoy.scenarios").joinpath(RADIOS, name + _SUFFIX).read_text(encoding="utf-8")
    return Technology.model_validate({"name": name, **YAML(typ="safe", pure=True).load(text)})
