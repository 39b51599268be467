"""Which frames a receiver misses, and which it gets damaged, under one section of loss."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus.keyed_random.draws import Purpose, uniforms
from zenvoy.channel.burst_loss import BurstLoss
from zenvoy.channel.path_loss import PathLossModel
from zenvoy.channel.rows import Rows, Scene
from zenvoy.scenarios import Loss

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class LossModel:
    """All that a section of loss asks for; sections of other `number` draw for themselves."""

    def __init__(self, loss: Loss, seed: int, size: int, number: int = 0) -> None:
        self._p, self._corrupt, self._seed = loss.p, loss.corrupt, seed
        self._bursts = BurstLoss(loss, seed, size, number)
        self._at_m, self._p_there = np.array(loss.by_distance).reshape(-1, 2).T
        self._path_loss = None
        if loss.path_loss is not None:
            self._path_loss = PathLossModel(loss.path_loss, seed, size, number)

    @property
    def draws(self) -> bool:
        """Whether `chance` counts."""
        return self._p > 0.0 or len(self._at_m) > 0 or self._path_loss is not None

    def lost(self, rows: Rows, scene: Scene, chance: Floats) -> Bools:
        """Which frames are lost, (r,); `chance`: a draw in [0, 1) for each."""
        lost = chance < self._probability(rows, scene)
        bursts = self._bursts.lost(rows.source, rows.destination, rows.sequence)
        return np.asarray(lost if bursts is None else lost | bursts)

    def _probability(self, rows: Rows, scene: Scene) -> float | Floats:
        """Of being lost to any of what draws for each frame anew."""
        p: float | Floats = self._p
        if len(self._at_m):
            p = p + (1.0 - p) * np.interp(rows.distance, self._at_m, self._p_there)
        if self._path_loss is not None:
            p = p + (1.0 - p) * self._path_loss.probability(rows, scene)
        return p

    def damaged(self, rows: Rows) -> Bools:
        """Which frames come damaged, (r,), lost or not."""
        if self._corrupt == 0.0:
            return np.zeros(len(rows.source), dtype=np.bool_)
        chance, _ = uniforms(self._seed, Purpose.CORRUPTION, *rows.keys)
        return np.asarray(chance < self._corrupt)
