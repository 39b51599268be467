"""Loss in bursts, with the meaning that Linux `tc netem` gives the parameters.

Both models step as net/sched/sch_netem.c does (loss_gilb_ell and loss_4state), with 53-bit draws
keyed by seed, link and sequence number in place of its random numbers.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus.keyed_random.draws import Purpose, numbered, uniforms
from zenvoy.channel.chains import Chains, Step
from zenvoy.scenarios import FourState, GilbertElliott, Loss

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

GOOD: Final = 0
BAD: Final = 1
RECEIVED_IN_GAP: Final = 0  # states 1 to 4 of netem, counted from 0
RECEIVED_IN_BURST: Final = 1
LOST_IN_BURST: Final = 2
LOST_IN_GAP: Final = 3


class BurstLoss:
    """What the burst models of a section lose among `size` vehicles.

    Those of another `number` draw for themselves.
    """

    def __init__(self, loss: Loss, seed: int, size: int, number: int = 0) -> None:
        steps = []
        if loss.gilbert_elliott != GilbertElliott():
            steps.append(gilbert_elliott(loss.gilbert_elliott, seed, number))
        if loss.four_state != FourState():
            steps.append(four_state(loss.four_state, seed, number))
        self._chains = [Chains(size, step) for step in steps]

    def lost(self, source: Ints, destination: Ints, sequence: Ints) -> Bools | None:
        """Which frames are lost; None where nothing can be. All (r,), indices from 0."""
        if not self._chains:
            return None
        lost = np.zeros(len(source), dtype=np.bool_)
        for chains in self._chains:
            lost |= chains.lost(source, destination, sequence)
        return lost


def gilbert_elliott(model: GilbertElliott, seed: int, number: int = 0) -> Step:
    """Step of Gilbert (1960) and Elliott (1963); the loss is that of the state before the step."""
    r = 1.0 - model.p if model.r is None else model.r
    purpose = numbered(Purpose.GILBERT_ELLIOTT, number)

    def step(state: Ints, who: Ints, whom: Ints, sequence: Ints) -> tuple[Ints, Bools]:
        move, loss = uniforms(seed, purpose, who + 1, whom + 1, sequence)
        bad = state == BAD
        moves = move < np.where(bad, r, model.p)
        lost = loss < np.where(bad, model.one_minus_h, model.one_minus_k)
        return np.where(bad ^ moves, BAD, GOOD), lost

    return step


def four_state(model: FourState, seed: int, number: int = 0) -> Step:
    """Step of the 4-state model (Salsano et al. 2009); the loss is that of the state reached."""
    purpose = numbered(Purpose.FOUR_STATE, number)
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
        draw, _ = uniforms(seed, purpose, who + 1, whom + 1, sequence)
        first, second = leaves[state].T
        to_first, to_second = targets[state].T
        after = np.where(draw < first, to_first, np.where(draw < second, to_second, state))
        return after, (after == LOST_IN_BURST) | (after == LOST_IN_GAP)

    return step
