"""Which frames a receiver misses, and which it gets damaged, under one section of loss."""

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
    """All that a section of loss asks for; sections of other `number` draw for themselves."""

    def __init__(self, loss: Loss, seeds: Seeds, number: int = 0) -> None:
        self._corruption = Draws(seeds, Purpose.CORRUPTION)
        self._judges: dict[Effect, list[Judge]] = {effect: [] for effect in Effect}
        for key, model in loss_models().items():
            value = getattr(loss, key)
            if value != model.default:
                self._judges[model.effect].append(model.judge(value, seeds, number))

    @property
    def never(self) -> bool:
        """Whether nothing is ever lost or damaged."""
        return not any(self._judges.values())

    @property
    def draws(self) -> bool:
        """Whether `chance` counts."""
        return bool(self._judges[Effect.LOSS_CHANCE])

    def lost(self, frames: SentFrames, scene: Scene, chance: Floats) -> Bools:
        """Return which frames are lost, (r,); `chance`: a draw in [0, 1) for each."""
        lost = np.asarray(chance < self._probability(Effect.LOSS_CHANCE, frames, scene))
        for judge in self._judges[Effect.LOSS]:
            lost |= judge(frames, scene)
        return lost

    def damaged(self, frames: SentFrames, scene: Scene) -> Bools:
        """Return which frames come damaged, (r,), lost or not."""
        if not self._judges[Effect.DAMAGE_CHANCE]:
            return np.zeros(len(frames.source), dtype=np.bool_)
        chance, _ = self._corruption.of_links(*frames.link)
        return np.asarray(chance < self._probability(Effect.DAMAGE_CHANCE, frames, scene))

    def _probability(self, effect: Effect, frames: SentFrames, scene: Scene) -> float | Floats:
        """That any of the models of an effect takes the frame, each for itself."""
        p: float | Floats = 0.0
        for judge in self._judges[effect]:
            p = p + (1.0 - p) * judge(frames, scene)
        return p
