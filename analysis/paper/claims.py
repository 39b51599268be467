"""The claims of the paper's evaluation in the paper's order, and their answers."""

from __future__ import annotations

from typing import Final

from zenvoy.analysis.paper import (
    claims_of_conclusion,
    claims_of_distances,
    claims_of_estimates,
    claims_of_max_distance,
    claims_of_speeds,
)
from zenvoy.analysis.paper.claim import Answer, Claim
from zenvoy.analysis.paper.evidence import MODELS, PAIRS, Evidence, case

CLAIMS: Final[tuple[Claim, ...]] = (
    *claims_of_estimates.CLAIMS,
    *claims_of_speeds.CLAIMS,
    *claims_of_distances.CLAIMS,
    *claims_of_max_distance.CLAIMS,
    *claims_of_conclusion.CLAIMS,
)

_CASES: Final = tuple(case(model, pair) for model in MODELS for pair in PAIRS)


def answers(evidence: Evidence) -> list[tuple[Claim, Answer]]:
    """Return every claim and its answer; a claim that needs longer runs is not tested."""
    return [(claim, _answer(claim, evidence)) for claim in CLAIMS]


def _answer(claim: Claim, evidence: Evidence) -> Answer:
    end_s = min(float(run.time_s[-1]) for label in _CASES for run in evidence[label])
    if end_s < claim.needs_s:
        why = f"The claim is about the first {claim.needs_s:g} s."
        return Answer(ours=f"the runs end at {end_s:g} s", verdict="not tested", why=why)
    return claim.answer(evidence)
