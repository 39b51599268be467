"""Sets of vehicles, as a scenario names them: "all", "2-9, 12", "humans", "not humans"."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping

from zenvoy.scenarios.wording import shown

_RANGE = re.compile(r"(\d+)(?:\s*-\s*(\d+))?")


def members(text: str, size: int, groups: Mapping[str, frozenset[int]]) -> frozenset[int]:
    """The vehicles, of 1..size, that `text` names; `groups` are those it may name.

    Raises ValueError, saying what is wrong and what is allowed.
    """
    everyone = frozenset(range(1, size + 1))
    terms = re.sub(r"^not\s+", "", text.strip())
    negated = terms != text.strip()
    found: frozenset[int] = frozenset()
    for term in terms.split(","):
        found |= _term(term.strip(), everyone, groups)
    return everyone - found if negated else found


def drawn(name: str, share: float, size: int, seed: int) -> frozenset[int]:
    """round(share · size) vehicles of 1..size, drawn by seed and by the name of their group."""

    def lot(vehicle: int) -> bytes:
        return hashlib.sha256(f"{seed}/{name}/{vehicle}".encode()).digest()

    return frozenset(sorted(range(1, size + 1), key=lot)[: round(share * size)])


def _term(
    term: str, everyone: frozenset[int], groups: Mapping[str, frozenset[int]]
) -> frozenset[int]:
    if term == "all":
        return everyone
    if term in groups:
        return groups[term]
    match = _RANGE.fullmatch(term)
    if match is None:
        names = "".join(f", {name}" for name in groups)
        raise ValueError(f"{shown(term)} is neither a vehicle nor a range nor one of all{names}")
    low, high = int(match[1]), int(match[2] or match[1])
    if not 1 <= low <= high <= len(everyone):
        raise ValueError(f"{term} is not within 1-{len(everyone)}, the vehicles of fleet.size")
    return frozenset(range(low, high + 1))
