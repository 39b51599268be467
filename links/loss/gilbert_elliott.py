"""Loss in bursts by Gilbert (1960) and Elliott (1963), in the notation of Linux `tc netem`.

It steps as net/sched/sch_netem.c does (loss_gilb_ell), but with 53-bit draws keyed by seed, link
and sequence number.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Draws
from zenvoy.links.chains import Chains, Step
from zenvoy.links.loss_model import Effect, Judge, LossModel
from zenvoy.values.section import Fraction, Section

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

GOOD: Final = 0
BAD: Final = 1


class GilbertElliott(Section):
    """Loss in bursts as in Linux `tc netem … loss gemodel p [r [1-h [1-k]]]`, with fractions.

    p: probability of a step from the good state to the bad one; r: of the step back (null: 1 - p).
    A frame is lost with probability one_minus_h in the bad state, and one_minus_k in the good one.
    """

    p: Fraction = 0.0
    """From the good state to the bad one, per frame."""
    r: Fraction | None = None
    """From the bad state to the good one; null: 1 − p."""
    one_minus_h: Fraction = 1.0
    """Loss in the bad state."""
    one_minus_k: Fraction = 0.0
    """Loss in the good state."""


def step_of(model: GilbertElliott, draws: Draws) -> Step:
    """Return the step of a link; the state before the step decides the loss."""
    r = 1.0 - model.p if model.r is None else model.r

    def step(state: Ints, who: Ints, whom: Ints, sequence: Ints) -> tuple[Ints, Bools]:
        move, loss = draws.of_links(who, whom, sequence)
        bad = state == BAD
        moves = move < np.where(bad, r, model.p)
        lost = loss < np.where(bad, model.one_minus_h, model.one_minus_k)
        return np.where(bad ^ moves, BAD, GOOD), lost

    return step


def start(model: GilbertElliott, draws: Draws, size: int) -> Judge:
    """Return a Judge that says which frames are lost, with a chain for each link."""
    return Chains(size, step_of(model, draws)).judge


LOSS = LossModel(
    key="gilbert_elliott",
    value=GilbertElliott,
    default=GilbertElliott(),
    effect=Effect.LOSS,
    start=start,
    meaning="Loss in bursts, with a good and a bad state.",
    place=5,
    purpose=20,
)
