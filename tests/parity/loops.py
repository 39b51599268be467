"""Ploeg's loop in theory: its gain, and the smallest headway with which it is string stable."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from tests.parity.cases import Floats

K_P: Final = 0.2
K_D: Final = 0.7
LAG_S: Final = 0.1


@dataclass(frozen=True, slots=True)
class Motion:
    """How the leader of a run moves: with harmonics of 1 / period_s, sampled every step_ms.

    settles_s: what a run leaves out at its start, s.
    """

    step_ms: int
    period_s: float
    harmonics: tuple[int, ...]
    settles_s: float = 30.0

    @property
    def omega(self) -> Floats:
        """The frequencies, rad/s."""
        return 2.0 * np.pi * np.array(self.harmonics) / self.period_s


# Without V2V the loop becomes unstable from low frequencies on, with V2V at about 0.47 rad/s.
SLOW: Final = Motion(20, 92.7, (1, 2, 3, 5, 8, 13, 21))
FAST: Final = Motion(5, 26.5, (1, 2, 3, 4, 6, 9))


@dataclass(frozen=True, slots=True)
class Loop:
    """A loop with this delay (s) of the command of the vehicle ahead; None: without V2V.

    published_s: its smallest string-stable headway, s. motion: that of the leader in its runs.
    """

    name: str
    delay_s: float | None
    published_s: float
    motion: Motion


LOOPS: Final = (
    Loop("ACC, without V2V", None, 3.16, SLOW),
    Loop("CACC, delay of 0.15 s", 0.15, 0.67, FAST),
    Loop("CACC, delay of 0.02 s", 0.02, 0.25, FAST),
)


def gain(loop: Loop, headway_s: float, omega: Floats) -> Floats:
    """Return the gain from the speed of the vehicle ahead to the own one, at frequencies in rad/s.

    Ploeg et al. (2011): (D + G K) / (H (1 + G K)) with the actuator and the vehicle in G, the
    controller K, the delay D and the headway in H.
    """
    s = 1j * omega
    feedback = (K_P + K_D * s) / (s * s * (LAG_S * s + 1.0))
    feedforward = 0.0 if loop.delay_s is None else np.exp(-loop.delay_s * s)
    gains: Floats = np.abs((feedforward + feedback) / ((headway_s * s + 1.0) * (1.0 + feedback)))
    return gains


def limit_in_theory(loop: Loop) -> float:
    """Return the smallest headway (s) with which no frequency is amplified, by bisection."""
    omega = np.geomspace(1e-3, 30.0, 50_001)
    low, high = 0.05, 10.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        amplified = bool((gain(loop, middle, omega) > 1.0 + 1e-12).any())
        low, high = (middle, high) if amplified else (low, middle)
    return high
