"""Loss by distance: straight lines between pairs of distance and probability."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field

from zenvoy.keyed_random.draws import Draws
from zenvoy.links.loss_model import Disagreement, Effect, Judge, LossModel
from zenvoy.values.section import Fraction, NonNegative
from zenvoy.values.wording import trimmed

Pair = Annotated[tuple[NonNegative, Fraction], Field(strict=False)]
Table = Annotated[tuple[Pair, ...], Field(strict=False)]  # a list is fine too


def start(table: tuple[tuple[float, float], ...], _draws: Draws, _size: int) -> Judge:
    """Return the probability that a frame is lost, (r,); beyond the table, the nearest value."""
    at_m, p = np.array(table).T
    return lambda frames, _scene: np.interp(frames.distance, at_m, p)


def disagreements(table: tuple[tuple[float, float], ...], key: str) -> Iterator[Disagreement]:
    """Yield the distances that do not increase."""
    for index, ((before, _), (distance, _)) in enumerate(pairwise(table), start=1):
        if distance <= before:
            text = (
                f"{trimmed(distance)} is not greater than the distance before ({trimmed(before)})"
            )
            yield Disagreement(f"{key}.{index}.0", text)


LOSS = LossModel(
    key="by_distance",
    value=Table,
    default=(),
    effect=Effect.LOSS_CHANCE,
    start=start,
    meaning="(m, probability) in order of distance: the loss between sender and receiver, on top. "
    "Straight lines lie between them; beyond, the nearest one counts.",
    disagreements=disagreements,
    place=3,
)
