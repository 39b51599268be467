"""How messages spell the settings and options of a scenario: each front end has its own way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple


class Spelling(NamedTuple):
    """The spelling of one front end. Arguments are given by their names in Python."""

    setting: Callable[[str], str]
    """Spells a `key=value` setting."""
    option: Callable[[str, object], str]
    """Spells an argument with its value, or with one value of its list."""
    argument: Callable[[str], str]
    """Spells the name of an argument."""
    allow_code: str
    """What runs code that is not beside the scenario."""


_REPEATED: Final = {
    "labels": "--label",
    "laws": "--law",
    "measures": "--measure",
    "settings": "--set",
}
"""Options that are given once for each value of a list."""


def _flag(argument: str) -> str:
    return _REPEATED.get(argument, f"--{argument.replace('_', '-')}")


def _flag_with(argument: str, value: object) -> str:
    return f"{_flag(argument)} {value}" if argument != "clock" else f"--{value}"


COMMAND_LINE: Final = Spelling(
    setting=lambda setting: f"--set {setting}",
    option=_flag_with,
    argument=_flag,
    allow_code="--allow-code",
)
PYTHON: Final = Spelling(
    setting=lambda setting: setting,
    option=lambda argument, value: f"{argument}={value}",
    argument=lambda argument: argument,
    allow_code="allow_code=True",
)
