"""Converts scalars of YAML 1.2 from text to values."""

from __future__ import annotations

from collections.abc import Callable

from ruamel.yaml.nodes import Node as YamlNode
from ruamel.yaml.nodes import ScalarNode

from zenvoy.scenarios.reading.tree import Scalar
from zenvoy.values.wording import shown

_TAG = "tag:yaml.org,2002:"


def scalar(node: YamlNode) -> Scalar:
    """Return the value of `node`; raises ValueError with what is wrong and what is allowed."""
    tag = (node.tag or "!").replace(_TAG, "!!")
    read = _READERS.get(tag) if isinstance(node, ScalarNode) else None
    if read is None:
        raise ValueError(f"the tag {tag} is not one of !!map, !!seq, {_ALLOWED_TAGS}")
    return read(node.value)


def text(value: str) -> str:
    """Return `value` itself; raises ValueError if it cannot be encoded as UTF-8."""
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(
            f"{shown(value)} is not text; half a surrogate pair is not a character"
        ) from None
    return value


def _null(_: str) -> None:
    return None


def _boolean(value: str) -> bool:
    try:
        return {"true": True, "false": False}[value.lower()]
    except KeyError:
        raise ValueError(f"{shown(value)} is not one of true, false") from None


def _integer(value: str) -> int:
    base = {"0o": 8, "0x": 16}.get(value.lstrip("+-")[:2].lower(), 10)
    try:
        number = int(value, base)
        float(number)
    except (ValueError, OverflowError):
        raise ValueError(f"{shown(value)} is not a whole number below 1e308") from None
    return number


def _real(value: str) -> float:
    try:
        return float(value.lower().replace(".inf", "inf").replace(".nan", "nan"))
    except ValueError:
        raise ValueError(f"{shown(value)} is not a number") from None


_READERS: dict[str, Callable[[str], Scalar]] = {
    "!!null": _null,
    "!!bool": _boolean,
    "!!int": _integer,
    "!!float": _real,
    "!!str": text,
}
_ALLOWED_TAGS = ", ".join(_READERS)
# YAML 1.2 has no dates, merge keys or default values, so a scalar that looks like one is text.
_READERS |= {"!!timestamp": text, "!!merge": text, "!!value": text}
