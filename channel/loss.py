"""Which frames a receiver misses, and which it gets damaged, under one section of loss."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus.draws import Purpose, uniforms
from zenvoy.channel.burst_loss import BurstLoss
from zenvoy.scenarios import Loss

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Rows(NamedTuple):
    """Frames by receiver, (r,): indices from 0 of both ends, distance in m, sequence numbers."""

    source: Ints
    destination: Ints
    distance: Floats
    sequence: Ints

    @property
    def keys(self) -> tuple[Ints, Ints, Ints]:
        """What keys their draws: numbers of both vehicles, from 1, and the frame's."""
        return self.source + 1, self.destination + 1, self.sequence

    def only(self, chosen: Bools) -> Rows:
        """Those of the rows."""
        return Rows._make(column[chosen] for column in self)


class LossModel:
    """All that a section of loss asks for; sections of other `number` draw for themselves."""

    def __init__(self, loss: Loss, seed: int, size: int, number: int = 0) -> None:
        self._p, self._corrupt, self._seed = loss.p, loss.corrupt, seed
        self._bursts = BurstLoss(loss, seed, size, number)
        self._at_m, self._p_there = np.array(loss.by_distance).reshape(-1, 2).T

    @property
    def draws(self) -> bool:
        """Whether `chance` counts."""
        return self._p > 0.0 or len(self._at_m) > 0

    def lost(self, rows: Rows, chance: Floats) -> Bools:
        """Which frames are lost, (r,); `chance`: a draw in [0, 1) for each."""
        p = self._p
        if len(self._at_m):
            there = np.interp(rows.distance, self._at_m, self._p_there)
            lost = chance < p + (1.0 - p) * there
        else:
            lost = chance < p
        bursts = self._bursts.lost(rows.source, rows.destination, rows.sequence)
        return np.asarray(lost if bursts is None else lost | bursts)

    def damaged(self, rows: Rows) -> Bools:
        """Which frames come damaged, (r,), lost or not."""
        if self._corrupt == 0.0:
            return np.zeros(len(rows.source), dtype=np.bool_)
        chance, _ = uniforms(self._seed, Purpose.CORRUPTION, *rows.keys)
        return np.asarray(chance < self._corrupt)
