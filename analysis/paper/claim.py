"""What a claim of the paper is, and what an answer to it is.

A verdict is worked out from the figures by rules, never put down by hand. What a claim says is in
our words; its figures are the paper's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from zenvoy.analysis.paper.evidence import Evidence, Pair

Verdict = Literal[
    "confirmed", "stronger", "weaker", "not confirmed", "contradicts itself", "not tested"
]

LOUD: Final = Pair(0.10, 0.1)
QUIET: Final = Pair(0.03, 0.1)
BILATERAL: Final = ("BCM", "MBCM", "PBCM")
END_S: Final = (400.0, 500.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """Our figures, the verdict, and its reason."""

    ours: str
    verdict: Verdict
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """Where the paper says it, what it says, how long the runs must be for it (s), the answer."""

    where: str
    says: str
    needs_s: float
    answer: Callable[[Evidence], Answer]


def claim(where: str, says: str, needs_s: float) -> Callable[[Callable[[Evidence], Answer]], Claim]:
    """Makes a claim of the function that answers it."""

    def made(answer: Callable[[Evidence], Answer]) -> Claim:
        return Claim(where=where, says=says, needs_s=needs_s, answer=answer)

    return made
