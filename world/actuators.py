"""Motion of vehicles whose acceleration follows the command with a first-order lag.

With time constant τ and a constant command u, da/dt = (u - a) / τ. The motion is exact:

a(t) = u + (a - u) e^(-t/τ), v(t) = v + u t + (a - u) k, x(t) = x + v t + u t²/2 + (a - u) τ (t - k)
with k = τ (1 - e^(-t/τ)).
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_HALVINGS: Final = 60  # leave less than 1e-18 of the span in which a vehicle stops


class Actuators:
    """Actuators with time constants `lag_s` (…, n), s; 0: without lag.

    `lagging` says which actuators lag. `acceleration` is what they give at present, m/s². Both are
    (…, n). The exponentials come from the C library, one per time constant, so that the motion of a
    vehicle is the same, bit for bit, in a fleet of any size.
    """

    def __init__(self, lag_s: Floats) -> None:
        self.lagging = lag_s > 0.0
        self.acceleration: Floats = np.zeros(lag_s.shape)
        self._lag_s = np.where(self.lagging, lag_s, 1.0)  # 1 is a placeholder: never used
        self._distinct_s, which = np.unique(self._lag_s, return_inverse=True)
        self._which = which.reshape(lag_s.shape)
        self._decays: dict[float, Floats] = {}  # by duration, s

    def advance(
        self, position: Floats, speed: Floats, command: Floats, dt_s: float
    ) -> tuple[Floats, Floats]:
        """Return positions and speeds after dt_s of constant commands, and update `acceleration`.

        The results for vehicles without lag have no meaning. A vehicle that comes to a standstill
        stays there until its actuator gives more than 0.
        """
        lag_s, decay = self._lag_s, self._decay_over(dt_s)
        start = self.acceleration
        apart, k = start - command, lag_s * (1.0 - decay)
        after = speed + command * dt_s + apart * k
        moved = position + speed * dt_s + 0.5 * command * (dt_s * dt_s) + apart * lag_s * (dt_s - k)
        self.acceleration = command + apart * decay
        dips = self.lagging & ((after < 0.0) | ((start < 0.0) & (command > 0.0)))
        for at in zip(*np.nonzero(dips), strict=True):
            found = _with_standstill(
                float(position[at]),
                float(speed[at]),
                float(start[at]),
                float(command[at]),
                float(lag_s[at]),
                dt_s,
            )
            if found is not None:
                moved[at], after[at] = found
        return moved, after

    def _decay_over(self, dt_s: float) -> Floats:
        if dt_s not in self._decays:
            if len(self._decays) > 1_000:  # events may cut cycles at any instant
                self._decays.clear()
            distinct = [math.exp(-dt_s / lag_s) for lag_s in self._distinct_s.tolist()]
            self._decays[dt_s] = np.array(distinct)[self._which]
        return self._decays[dt_s]


def _with_standstill(
    x: float, v: float, a: float, u: float, lag_s: float, dt_s: float
) -> tuple[float, float] | None:
    """Return position and speed after dt_s of a vehicle that stands for a while; else None.

    The acceleration changes sign at most once, so the speed has at most one minimum or one maximum
    in between.
    """

    def at(t: float) -> tuple[float, float]:
        k = lag_s * (1.0 - math.exp(-t / lag_s))
        return x + v * t + 0.5 * u * t * t + (a - u) * lag_s * (t - k), v + u * t + (a - u) * k

    turns = dt_s if a * u >= 0.0 else min(dt_s, lag_s * math.log((a - u) / -u))
    low, high = (0.0, turns) if a < 0.0 else (turns if a * u < 0.0 else 0.0, dt_s)
    if at(high)[1] >= 0.0:
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if at(middle)[1] < 0.0 else (middle, high)
    stands_at = at(low)[0]
    if not (a < 0.0 < u and turns < dt_s):
        return stands_at, 0.0
    # The vehicle moves off when its actuator reaches 0.
    left = dt_s - turns
    k = lag_s * (1.0 - math.exp(-left / lag_s))
    return stands_at + 0.5 * u * left * left - u * lag_s * (left - k), u * left - u * k
