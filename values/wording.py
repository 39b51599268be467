"""Formats values, numbers and keys for messages, with a limit on their length."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import islice
from typing import Final

_LONGEST: Final = 60
_LONGEST_SOURCE: Final = 300
_MOST_NAMES: Final = 24


def one_line(text: str, longest: int = _LONGEST_SOURCE) -> str:
    """Return `text` cut to a length, with control characters and line breaks escaped."""
    text = text[: longest + 1]
    text = text if text.isprintable() else repr(text)[1:-1]
    return text if len(text) <= longest else text[: longest - 1] + "…"


def capitalized(text: str) -> str:
    """Return a text with a capital letter at its start."""
    return text[:1].upper() + text[1:]


def dotted(path: Iterable[str | int]) -> str:
    """Return ("events", 0, "vehicle") as "events.0.vehicle"."""
    return ".".join(one_line(str(step), _LONGEST) for step in path)


def shown(value: object) -> str:
    """Return a value in a form that its author recognises, at most 60 characters long."""
    match value:
        case None | True | False:
            return {None: "null", True: "true", False: "false"}[value]
        case Mapping():
            return "a mapping"
        case list() | tuple():
            return "a list"
        case str():
            value = value[: _LONGEST + 1]
    text = repr(value)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def shown_list(values: Sequence[object]) -> str:
    """Return a list with its entries, at most 60 characters long."""
    entries = ", ".join(shown(value) for value in values[:_LONGEST])
    return one_line(f"[{entries}]", _LONGEST)


def kind_of(value: object) -> str:
    """Return the kind of a value without showing it: the text of a file may be a secret."""
    match value:
        case Mapping() | list() | tuple() | None | bool():
            return shown(value)
        case str():
            return "text"
        case _:
            return "a number"


def listed(names: Collection[str]) -> str:
    """Return the first 24 names, separated by commas, and the number of the others."""
    more = len(names) - _MOST_NAMES
    text = ", ".join(one_line(name, _LONGEST) for name in islice(names, _MOST_NAMES))
    return f"{text} and {more} more" if more > 0 else text


def trimmed(number: float) -> str:
    """Return the shortest text that reads as the same number: 100 for 100.0, 1e9 for 1e+09."""
    short = f"{number:g}"
    if float(short) != number:
        short = str(number).removesuffix(".0")
    mantissa, e, exponent = short.partition("e")
    return f"{mantissa}e{int(exponent)}" if e else short


def spans(numbers: Collection[int]) -> str:
    """Return numbers in the notation of a scenario: "1-4, 7, 9-12"."""
    found: list[list[int]] = []
    for number in sorted(numbers):
        if found and found[-1][1] == number - 1:
            found[-1][1] = number
        else:
            found.append([number, number])
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in found)
