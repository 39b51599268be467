"""Shadowing: a normally distributed gain in dB for each pair of vehicles, varying as they move.

S' = ρ S + √(1 - ρ²) N with ρ = exp(-Δ / decorrelation). Δ is the distance that both vehicles have
moved since S (Gudmundson 1991; 3GPP TR 36.885). It is the same in both directions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Draws
from zenvoy.links.sent_frames import Scene, SentFrames

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Shadowing:
    """The shadowing of the pairs of `size` vehicles that are asked for, in dB.

    Each pair has one draw per cycle, keyed by the cycle. Its shadowing also depends on the distance
    moved, and so on the run.
    """

    def __init__(self, std_db: float, decorrelation_m: float, draws: Draws, size: int) -> None:
        self._std_db, self._decorrelation_m = std_db, decorrelation_m
        self._draws, self._size = draws, size
        # A row per pair, in ascending order of its code: its value, and the positions of both
        # vehicles at that time.
        self._code = np.zeros(0, dtype=np.int64)
        self._value, self._low_at, self._high_at = (np.zeros(0) for _ in range(3))

    def of(self, frames: SentFrames, scene: Scene) -> Floats:
        """Return the shadowing of the frames, dB, (r,); to be called once per cycle."""
        if self._std_db == 0.0:
            return np.zeros(len(frames.source))
        low = np.minimum(frames.source, frames.destination)
        high = np.maximum(frames.source, frames.destination)
        code, back = np.unique(low * self._size + high, return_inverse=True)
        low, high = np.divmod(code, self._size)
        value = self._moved(code, low, high, scene)
        return np.asarray(self._std_db * value[back])

    def _moved(self, code: Ints, low: Ints, high: Ints, scene: Scene) -> Floats:
        """Return and keep the present values of the pairs, with unit variance."""
        place = scene.position
        fresh = self._draws.normals_of_links(low, high, scene.cycle)
        at = np.searchsorted(self._code, code)
        known = at < len(self._code)
        known[known] = self._code[at[known]] == code[known]
        rows = at[known]
        way = np.abs(place[low[known]] - self._low_at[rows])
        way += np.abs(place[high[known]] - self._high_at[rows])
        kept = np.exp(-way / self._decorrelation_m)
        value = fresh.copy()
        value[known] = kept * self._value[rows] + np.sqrt(1.0 - kept * kept) * fresh[known]
        if not known.all():
            self._put_in(code[~known])
            at = np.searchsorted(self._code, code)
        self._value[at], self._low_at[at], self._high_at[at] = value, place[low], place[high]
        return value

    def _put_in(self, code: Ints) -> None:
        places = np.searchsorted(self._code, code)
        self._code = np.insert(self._code, places, code)
        self._value = np.insert(self._value, places, 0.0)
        self._low_at = np.insert(self._low_at, places, 0.0)
        self._high_at = np.insert(self._high_at, places, 0.0)
