"""How messages spell the settings and options of a scenario: each front end has its own way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple


class Spelling(NamedTuple):
    """The spelling of one front end."""

    setting: Callable[[str], str]
    """Spells a `key=value` setting."""
    option: Callable[[str, object], str]
    """Spells an option that replaces a key of the top level, such as seed."""
    allow_code: str
    """What runs code that is not beside the scenario."""


def _flag(key: str, value: object) -> str:
    return f"--{key.replace('_', '-')} {value}" if key != "clock" else f"--{value}"


COMMAND_LINE: Final = Spelling(
    setting=lambda setting: f"--set {setting}", option=_flag, allow_code="--allow-code"
)
