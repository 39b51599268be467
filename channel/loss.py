"""Loss and damage of frames under one section of a scenario."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Draws, Purpose, Seeds
from zenvoy.links.loss_model import Effect, Judge
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.links.table import loss_models
from zenvoy.scenarios import Loss

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Losses:
    """The loss models of one section; sections with different `number` have independent draws."""

    def __init__(self, loss: Loss, seeds: Seeds, number: int = 0) -> None:
        self._corruption = Draws(seeds, Purpose.CORRUPTION)
        self._judges: dict[Effect, list[Judge]] = {effect: [] for effect in Effect}
        for key, model in loss_models().items():
            value = getattr(loss, key)
            if value != model.default:
                self._judges[model.effect].append(model.judge(value, seeds, number))

    @property
    def never(self) -> bool:
        """Whether no frame is ever lost or damaged."""
        return not any(self._judges.values())

    @property
    def draws(self) -> bool:
        """Whether `lost` uses its argument `chance`."""
        return bool(self._judges[Effect.LOSS_CHANCE])

    def lost(self, frames: SentFrames, scene: Scene, chance: Floats) -> Bools:
        """Return which frames are lost, (r,); chance: a draw in [0, 1) for each frame."""
        lost = np.asarray(chance < self._probability(Effect.LOSS_CHANCE, frames, scene))
        for judge in self._judges[Effect.LOSS]:
            lost |= judge(frames, scene)
        return lost

    def damaged(self, frames: SentFrames, scene: Scene) -> Bools:
        """Return which frames are damaged, (r,), whether lost or not."""
        if not self._judges[Effect.DAMAGE_CHANCE]:
            return np.zeros(len(frames.source), dtype=np.bool_)
        chance, _ = self._corruption.of_links(*frames.link)
        return np.asarray(chance < self._probability(Effect.DAMAGE_CHANCE, frames, scene))

    def _probability(self, effect: Effect, frames: SentFrames, scene: Scene) -> float | Floats:
        """Return the probability that one or more of the independent models of an effect hit."""
        p: float | Floats = 0.0
        for judge in self._judges[effect]:
            p = p + (1.0 - p) * judge(frames, scene)
        return p
