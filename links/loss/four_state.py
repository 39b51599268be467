"""Loss in bursts with four states (Salsano et al. 2009), in the notation of Linux `tc netem`.

It steps as net/sched/sch_netem.c does (loss_4state), but with 53-bit draws keyed by seed, link and
sequence number.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Draws
from zenvoy.links.chains import Chains, Step
from zenvoy.links.loss_model import Disagreement, Effect, Judge, LossModel
from zenvoy.values.section import Fraction, Section
from zenvoy.values.wording import trimmed

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

RECEIVED_IN_GAP: Final = 0  # states 1 to 4 of netem, counted from 0
RECEIVED_IN_BURST: Final = 1
LOST_IN_BURST: Final = 2
LOST_IN_GAP: Final = 3


class FourState(Section):
    """Loss as in `tc netem … loss state p13 [p31 [p32 [p23 [p14]]]]`, with fractions.

    States: 1 received in a gap, 2 received in a burst, 3 lost in a burst, 4 lost in a gap. If p31
    is null, it is 1 - p13.
    """

    p13: Fraction = 0.0
    """A burst begins, with a loss."""
    p31: Fraction | None = None
    """A burst ends; null: 1 − p13."""
    p32: Fraction = 0.0
    """A frame gets through within a burst."""
    p23: Fraction = 1.0
    """The burst goes on after that."""
    p14: Fraction = 0.0
    """A single loss outside of bursts."""


def disagreements(model: FourState, key: str) -> Iterator[Disagreement]:
    """Yield the transitions out of a state whose probabilities add up to more than 1."""
    leaving = {"p14": (model.p14, "p13", model.p13), "p32": (model.p32, "p31", model.p31 or 0)}
    for name, (value, other, beside) in leaving.items():
        if value + beside > 1:
            also = f"{key}.{other}"
            text = f"{trimmed(value)} and {also} ({trimmed(beside)}) are more than 1 together"
            yield Disagreement(f"{key}.{name}", text, (also,))


def step_of(model: FourState, draws: Draws) -> Step:
    """Return the step of a link; the state after the step decides the loss."""
    p31 = 1.0 - model.p13 if model.p31 is None else model.p31
    leaves = np.array(  # cumulated probabilities, by state: to the first, first or second target
        [
            (model.p14, model.p14 + model.p13),
            (model.p23, model.p23),
            (model.p32, model.p32 + p31),
            (1.0, 1.0),
        ]
    )
    targets = np.array(
        [
            (LOST_IN_GAP, LOST_IN_BURST),
            (LOST_IN_BURST, LOST_IN_BURST),
            (RECEIVED_IN_BURST, RECEIVED_IN_GAP),
            (RECEIVED_IN_GAP, RECEIVED_IN_GAP),
        ]
    )

    def step(state: Ints, who: Ints, whom: Ints, sequence: Ints) -> tuple[Ints, Bools]:
        draw, _ = draws.of_links(who, whom, sequence)
        first, second = leaves[state].T
        to_first, to_second = targets[state].T
        after = np.where(draw < first, to_first, np.where(draw < second, to_second, state))
        return after, (after == LOST_IN_BURST) | (after == LOST_IN_GAP)

    return step


def start(model: FourState, draws: Draws, size: int) -> Judge:
    """Return a Judge that says which frames are lost, with a chain for each link."""
    return Chains(size, step_of(model, draws)).judge


LOSS = LossModel(
    key="four_state",
    value=FourState,
    default=FourState(),
    effect=Effect.LOSS,
    start=start,
    meaning="Loss in bursts and gaps, with four states.",
    disagreements=disagreements,
    place=6,
    purpose=21,
)
