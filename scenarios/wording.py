"""How values, numbers and keys are shown in messages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

_LONGEST = 60
_MOST_NAMES = 24


def one_line(text: str) -> str:
    """`text` itself, or with escapes where it would break the line or the terminal."""
    return text if text.isprintable() else repr(text)[1:-1]


def dotted(path: Iterable[str | int]) -> str:
    """("events", 0, "vehicle") as events.0.vehicle."""
    return ".".join(one_line(str(step)) for step in path)


def shown(value: object) -> str:
    """A value as its author would recognise it, at most 60 characters long."""
    match value:
        case None | True | False:
            return {None: "null", True: "true", False: "false"}[value]
        case Mapping():
            return "a mapping"
        case list() | tuple():
            return "a list"
        case _:
            text = repr(value)
            return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def listed(names: Sequence[str]) -> str:
    """Names with commas between them, the first 24 and how many more there are."""
    more = len(names) - _MOST_NAMES
    text = ", ".join(map(one_line, names[:_MOST_NAMES]))
    return text if more <= 0 else f"{text} and {more} more"


def trimmed(number: float) -> str:
    """The shortest text that reads as the same number: 100.0 as 100, 1e+09 as 1e9."""
    short = f"{number:g}"
    if float(short) != number:
        short = str(number).removesuffix(".0")
    mantissa, e, exponent = short.partition("e")
    return f"{mantissa}e{int(exponent)}" if e else short
