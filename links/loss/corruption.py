"""Damage: each frame arrives damaged with the same probability, and the receiver drops it."""

from __future__ import annotations

from zenvoy.keyed_random.draws import Draws
from zenvoy.links.loss_model import Effect, Judge, LossModel
from zenvoy.values.section import Fraction


def start(p: float, _draws: Draws, _size: int) -> Judge:
    """Return the probability that a frame arrives damaged."""
    return lambda _frames, _scene: p


LOSS = LossModel(
    key="corrupt",
    value=Fraction,
    default=0.0,
    effect=Effect.DAMAGE_CHANCE,
    start=start,
    meaning="Probability that a frame arrives damaged; the receiver drops it.",
    place=4,
)
