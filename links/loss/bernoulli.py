"""Independent loss: each frame is lost with the same probability (Bernoulli)."""

from __future__ import annotations

from zenvoy.keyed_random.draws import Draws
from zenvoy.links.loss_model import Effect, Judge, LossModel
from zenvoy.values.section import Fraction


def start(p: float, _draws: Draws, _size: int) -> Judge:
    """Return the probability that a frame is lost."""
    return lambda _frames, _scene: p


LOSS = LossModel(
    key="p",
    value=Fraction,
    default=0.0,
    effect=Effect.LOSS_CHANCE,
    start=start,
    meaning="Probability with which a receiver misses a frame.",
    place=1,
)
