"""How far a vehicle ahead that is not heard may have strayed from uniform motion.

Its radar reading, minus what uniform motion predicts, measures this deviation. The deviation is 0
as long as the vehicle is heard, so the Kalman gain depends only on the number of readings since.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from zenvoy.vehicles.gains import Covariance, GainSchedule

UNHEARD_STD: Final = 0.5
"""Standard deviation of the acceleration of a vehicle that is not heard, m/s²."""

_MOST: Final = 1_000

Gain = list[list[float]]


@lru_cache(maxsize=16)
def unheard_gains(period_s: float, variances: tuple[float, float]) -> tuple[Gain, ...]:
    """Return the gain K (2, 2) of the 1st, 2nd, … reading since the vehicle was heard.

    The last one holds for all later readings. variances: of readings of gap and relative speed.
    """
    schedule = GainSchedule(period_s, UNHEARD_STD, variances)
    point = Covariance(np.zeros((2, 2)), [])
    gains: list[Gain] = []
    while len(gains) < _MOST and (after := schedule.step(point, 1)) is not point:
        point = after
        gains.append(point.K)
    return tuple(gains)
