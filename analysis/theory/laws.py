"""Linear theory of the control laws: one vehicle behind another, with and without delay.

The theory covers small deviations from the equilibrium of equal gaps and the desired speed, for
which the laws are linear. The whole command is delayed: with total delay τ the host's acceleration
at t is what its law returns for t - τ. An actuator may also follow the command as a first-order lag
of time constant T, so that a command reaches the acceleration as e^(-sτ) / (T s + 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Control, Gains

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


class Coupling(NamedTuple):
    """The weights of a law's neighbours: `ahead[j - 1]` is the weight of the j-th ahead."""

    ahead: tuple[float, ...]
    behind: tuple[float, ...]


FM: Final = Coupling((1.0,), ())
BCM: Final = Coupling((1.0,), (1.0,))  # also PBCM, whose prediction removes the delay


def mbcm(weights: Sequence[float]) -> Coupling:
    """Return MBCM with weights c_1 .. c_m, which are the same on both sides."""
    return Coupling(tuple(weights), tuple(weights))


class Peak(NamedTuple):
    """The largest gain, and its frequency, rad/s (0 if no gain is above 1)."""

    gain: float
    omega: float


def total_delay_s(control: Control, period_ms: float, *, predicts: bool = False) -> float:
    """Return the delay of the commands, s: the wait for V2V, the system's delay, and half a period.

    A command holds for a period, so the acting command is half a period old on average. The
    zero-order hold is (1 - exp(-sT)) / sT = exp(-sT/2) · (1 + O((ωT)²)). A law that `predicts`,
    such as PBCM, acts on the state at which its command takes effect, so only the hold remains.
    """
    known = 0.0 if predicts else (control.v2v_wait_ms or 0.0) + control.system_delay_ms
    return (known + 0.5 * period_ms) * 1e-3


def lateness(omega: Floats, delay_s: float, lag_s: float) -> Complexes:
    """Return L(jω), from command to acceleration: L(s) = e^(-sτ) / (T s + 1); ω in rad/s."""
    s = 1j * omega
    return np.asarray(np.exp(-s * delay_s) / (lag_s * s + 1.0))


def transfer(omega: Floats, gains: Gains, delay_s: float = 0.0, lag_s: float = 0.0) -> Complexes:
    """Return H(jω) of FM (F,), from the speed (or position) of the vehicle ahead to the host's.

    H(s) = (k_v s + k_d) L / (s² + ((k_v + k_c) s + k_d) L), L = e^(-sτ) / (T s + 1); ω in rad/s.
    """
    s = 1j * np.asarray(omega, dtype=np.float64)
    late = lateness(omega, delay_s, lag_s)
    numerator = (gains.k_v * s + gains.k_d) * late
    return np.asarray(numerator / (s * s + ((gains.k_v + gains.k_c) * s + gains.k_d) * late))


def is_string_stable(gains: Gains) -> bool:
    """Return whether FM at once damps every frequency: κ² + 2 k_v κ ≥ 2 k_d, with κ = k_c."""
    return gains.k_c**2 + 2.0 * gains.k_v * gains.k_c >= 2.0 * gains.k_d


def peak_gain(gains: Gains, delay_s: float = 0.0, lag_s: float = 0.0) -> Peak:
    """Return the largest |H(jω)| of FM, for k_d > 0.

    With a delay or a lag, a single vehicle must be stable. Without either there is a closed form:
    |H|² is a ratio of polynomials in u = ω², and its derivative vanishes where
    k_v² u² + 2 k_d² u + k_d² ((k_v + k_c)² - k_v² - 2 k_d) = 0.
    """
    if delay_s > 0.0 or lag_s > 0.0:
        return _peak_by_search(gains, delay_s, lag_s)
    if is_string_stable(gains):
        return Peak(1.0, 0.0)
    k_d, k_v = gains.k_d, gains.k_v
    rest = 2.0 * k_d - gains.k_c**2 - 2.0 * k_v * gains.k_c  # > 0
    # This form of the positive root also holds for k_v = 0.
    u = rest / (1.0 + np.sqrt(1.0 + k_v**2 * rest / k_d**2))
    omega = float(np.sqrt(u))
    return Peak(float(abs(transfer(np.array([omega]), gains)[0])), omega)


def group_delay_s(omega: float, gains: Gains, delay_s: float = 0.0, lag_s: float = 0.0) -> float:
    """Return the group delay of FM at ω, s per vehicle: -d arg H / dω.

    At ω = 0 it is k_c / k_d for any delay and lag.
    """
    step = 1e-4 * max(omega, np.sqrt(gains.k_d), 1e-3)
    below, above = transfer(np.array([omega - step, omega + step]), gains, delay_s, lag_s)
    return float(-np.angle(above / below) / (2.0 * step))


def _peak_by_search(gains: Gains, delay_s: float, lag_s: float) -> Peak:
    """Zoom in on the largest gain, from a grid that is finer than any resonance."""
    low, high = 0.0, 4.0 * (gains.k_v + gains.k_c + np.sqrt(gains.k_d))  # |H| < 1 above
    for _ in range(6):
        omega = np.linspace(low, high, 2001)
        gain = np.abs(transfer(omega[1:], gains, delay_s, lag_s))
        best = 1 + int(np.argmax(gain))
        low, high = omega[best - 1], omega[min(best + 1, 2000)]
    if gain.max() <= 1.0 + 1e-9:
        return Peak(1.0, 0.0)
    return Peak(float(gain.max()), float(omega[best]))
