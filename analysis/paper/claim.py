"""A claim of the paper, and the answer to it.

Rules compute a verdict from the figures; it is never written by hand. The text of a claim is in our
words, its figures are the paper's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from zenvoy.analysis.paper.evidence import Evidence, Pair

Verdict = Literal[
    "confirmed", "stronger", "weaker", "not confirmed", "contradicts itself", "not tested"
]

LARGE_ERROR: Final = Pair(0.10, 0.1)
SMALL_ERROR: Final = Pair(0.03, 0.1)
BILATERAL: Final = ("BCM", "MBCM", "PBCM")
END_S: Final = (400.0, 500.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """An answer to a claim: our figures, the verdict, and its reason."""

    ours: str
    verdict: Verdict
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A claim: where the paper makes it, its text, the run time that it needs (s), the answer."""

    where: str
    says: str
    needs_s: float
    answer: Callable[[Evidence], Answer]


def claim(where: str, says: str, needs_s: float) -> Callable[[Callable[[Evidence], Answer]], Claim]:
    """Return a decorator that turns the function that answers a claim into the claim."""

    def made(answer: Callable[[Evidence], Answer]) -> Claim:
        return Claim(where=where, says=says, needs_s=needs_s, answer=answer)

    return made
