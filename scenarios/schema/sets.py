"""Sets of vehicles in the notation of a scenario: "all", "2-9, 12", "humans", "not humans"."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection, Mapping

from zenvoy.values.wording import listed, shown

_RANGE = re.compile(r"(\d{1,9})(?:\s*-\s*(\d{1,9}))?", re.ASCII)


def members(text: str, size: int, groups: Mapping[str, frozenset[int]]) -> frozenset[int]:
    """Return the vehicles of 1..size that `text` names; it may name these `groups`.

    Raises ValueError with what is wrong and what is allowed.
    """
    negated, terms = _terms(text)
    found: set[int] = set()
    for term in terms:
        found.update(groups[term] if term in groups else _span(term, size, groups))
    if negated:
        return frozenset(range(1, size + 1)).difference(found)
    return frozenset(found)


def at_most(text: str, size: int, groups: Mapping[str, int]) -> int:
    """Return an upper bound on the number of vehicles that `text` names.

    `groups` has the bounds of the groups. The time is linear in the length of the text. Raises
    ValueError for the same texts as `members`.
    """
    negated, terms = _terms(text)
    count = sum(
        groups[term] if term in groups else len(_span(term, size, groups)) for term in terms
    )
    return size if negated else min(count, size)


def _terms(text: str) -> tuple[bool, list[str]]:
    """Return whether `text` begins with "not", and the terms that it names."""
    terms = re.sub(r"^not\s+", "", text.strip())
    return terms != text.strip(), [term.strip() for term in terms.split(",")]


def drawn(name: str, share: float, size: int, seed: int) -> frozenset[int]:
    """Return round(share · size) vehicles of 1..size, drawn by seed and the name of the group."""

    def lot(vehicle: int) -> bytes:
        return hashlib.sha256(f"{seed}/{name}/{vehicle}".encode()).digest()

    return frozenset(sorted(range(1, size + 1), key=lot)[: round(share * size)])


def _span(term: str, size: int, groups: Collection[str]) -> range:
    """Return the vehicles of "all", of a number or of a range; raises ValueError."""
    if term == "all":
        return range(1, size + 1)
    match = _RANGE.fullmatch(term)
    if match is None:
        names = f"all, {listed(groups)}" if groups else "all"
        raise ValueError(f"{shown(term)} is not a vehicle, a range or one of {names}")
    low, high = int(match[1]), int(match[2] or match[1])
    if not 1 <= low <= high <= size:
        raise ValueError(f"{term} is not within 1-{size}, the vehicles of fleet.size")
    return range(low, high + 1)
