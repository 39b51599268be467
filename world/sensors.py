"""Readings of the sensors: true values with errors."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from zenvoy.keyed_random.draws import Purpose, normals, uniforms
from zenvoy.scenarios import Sensors

Floats = NDArray[np.float64]

_BLOCK: Final = 64  # cycles drawn at once, because a draw costs more per call than per number
_AT_ONCE: Final = 8_192  # numbers drawn at once at the most, so that they fit the caches


class Readings(NamedTuple):
    """Radar gap (m) and relative speed (m/s), own position (m) and speed (m/s), all (…, n)."""

    gap: Floats
    relative_speed: Floats
    position: Floats
    speed: Floats


class SensorSet:
    """The sensors of the whole fleet, whose errors are keyed by seed, vehicle and cycle."""

    def __init__(self, settings: Sensors, seed: ArrayLike, size: int) -> None:
        """Take the seed: a number, or a column (runs, 1) of numbers."""
        self._settings = settings
        self._seed = np.asarray(seed, np.uint64)
        self._vehicles = np.arange(1, size + 1)
        self._block = min(_BLOCK, 1 + _AT_ONCE // (size * self._seed.size))
        self._errors: dict[Purpose, Floats] = {}
        self._first = -1

    def read(self, cycle: int, gap: Floats, position: Floats, speed: Floats) -> Readings:
        """Return the readings of a cycle from true gaps (m), positions (m), speeds (m/s), (…, n).

        Gaps and speeds are read with a relative error, positions with an absolute one. The error of
        the radar's relative speed is relative to the speed of the vehicle ahead, and independent of
        the host's own speedometer.
        """
        errors = self._of_cycle(cycle)
        ahead = np.concatenate((speed[..., -1:], speed[..., :-1]), axis=-1)
        target = ahead * (1.0 + errors[Purpose.TARGET_SPEED_READING])
        return Readings(
            gap=gap * (1.0 + errors[Purpose.GAP_READING]),
            relative_speed=np.where(np.isnan(gap), np.nan, target - speed),
            position=position + errors[Purpose.POSITION_READING],
            speed=speed * (1.0 + errors[Purpose.SPEED_READING]),
        )

    def _of_cycle(self, cycle: int) -> dict[Purpose, Floats]:
        if not self._first <= cycle < self._first + self._block or self._first < 0:
            self._first = cycle - cycle % self._block
            self._draw()
        row = cycle - self._first
        return {purpose: block[row] for purpose, block in self._errors.items()}

    def _draw(self) -> None:
        cycles = np.arange(self._first, self._first + self._block)
        number = cycles.reshape(-1, *(1,) * max(1, self._seed.ndim))
        keys = (self._vehicles, 0, number)
        for purpose in (Purpose.GAP_READING, Purpose.SPEED_READING, Purpose.TARGET_SPEED_READING):
            if self._settings.distribution == "uniform":
                share = 2.0 * uniforms(self._seed, purpose, *keys)[0] - 1.0
                self._errors[purpose] = self._settings.error * share
            else:
                normal = normals(self._seed, purpose, *keys)
                self._errors[purpose] = self._settings.error_std * normal
        purpose = Purpose.POSITION_READING
        if self._settings.position_std_m == 0.0:
            self._errors[purpose] = np.zeros((self._block, len(self._vehicles)))
        else:
            normal = normals(self._seed, purpose, *keys)
            self._errors[purpose] = self._settings.position_std_m * normal
