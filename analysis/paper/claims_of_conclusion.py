"""The claim of the conclusion of Section IV."""

from __future__ import annotations

from typing import Final

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.paper.claim import Answer, claim
from zenvoy.analysis.paper.evidence import MODELS, PAIRS, Evidence, Pair, case, settled


@claim(
    where="Section IV, conclusion",
    says="With errors and delays PBCM is better than FM, BCM and MBCM",
    needs_s=500,
)
def best_everywhere(evidence: Evidence) -> Answer:
    texts = []
    for pair in PAIRS:
        pbcm = evidence.over(case("PBCM", pair), _after_100)
        spread = evidence.over(case("PBCM", pair), _spread_after_100)
        texts.append(f"{pair.title}: PBCM {pbcm.text()} m, {spread.text(3)} m/s")
    best = all(_is_best(evidence, "", pair) for pair in PAIRS)
    why = (
        "At each of the four pairs, PBCM's 95 % intervals of both quantities do not overlap with"
        " those of any other model."
        if best
        else "At some pairs PBCM's 95 % intervals overlap with those of another model."
    )
    if "open/" + case("PBCM", PAIRS[0]) in evidence.runs:
        there = sum(_is_best(evidence, "open/", pair) for pair in PAIRS)
        why += f" On the open road the same is true for {there} of the four pairs."
    return Answer(
        ours="MinDistance after 100 s and spread of speed: " + "; ".join(texts),
        verdict="confirmed" if best else "not confirmed",
        why=why,
    )


def _is_best(evidence: Evidence, road: str, pair: Pair) -> bool:
    """Return whether PBCM's MinDistance and spread are better than those of each other model."""
    pbcm = evidence.over(road + case("PBCM", pair), _after_100)
    spread = evidence.over(road + case("PBCM", pair), _spread_after_100)
    others = [road + case(model, pair) for model in MODELS[:3]]
    return all(
        pbcm.above(evidence.over(label, _after_100))
        and evidence.over(label, _spread_after_100).above(spread)
        for label in others
    )


def _spread_after_100(run: Digest) -> float:
    return settled(run, "spread", 100.0, 500.0)


def _after_100(run: Digest) -> float:
    return settled(run, "min_distance", 100.0, 500.0)


CLAIMS: Final = (best_everywhere,)
