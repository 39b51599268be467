"""Linear theory of the ring: how each mode decays or grows, and how fast waves travel.

On the ring a deviation x_i = e^(iθi) e^(st) keeps its shape: mode n of N vehicles has θ = 2πn/N.
Its exponent s solves (T s + 1) s² + ((k_v λ + k_c) s + k_d λ) e^(-sτ) = 0, with delay τ, lag T and
λ(θ) = Σ_j ahead_j (1 - e^(-iθj)) + Σ_j behind_j (1 - e^(iθj)), which is 2 (1 - cos θ) for BCM.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from zenvoy.analysis.theory.delay_line import delay_line
from zenvoy.analysis.theory.laws import Complexes, Coupling, Floats
from zenvoy.scenarios import Gains

_NEWTON_STEPS: Final = 6
_NEAR: Final = 0.01  # relative error of an eigenvalue that approximates a root
_ROUNDING: Final = 1e-12  # rad/s; a smaller frequency is a rounding error of 0


class Mode(NamedTuple):
    """Mode `number` of the ring: growth rate (1/s, negative for a decay), frequency (rad/s)."""

    number: int
    rate: float
    omega: float


def eigenvalue(coupling: Coupling, theta: Floats) -> Complexes:
    """Return λ(θ) in the shape of `theta`; it is real for symmetric couplings."""
    theta = np.asarray(theta, dtype=np.float64)
    total = np.zeros(theta.shape, dtype=np.complex128)
    for sign, weights in ((-1j, coupling.ahead), (1j, coupling.behind)):
        for j, weight in enumerate(weights, start=1):
            total += weight * (1.0 - np.exp(sign * theta * j))
    return total


def roots(lam: Complexes, gains: Gains, delay_s: float = 0.0, lag_s: float = 0.0) -> Complexes:
    """Return the roots s (d, ...) with the largest real parts, the slowest to decay first.

    Without a delay there are only d of them, two or with a lag three. With a delay there are
    infinitely many. The first d are found as eigenvalues of the vehicle and its delay line, and
    refined to full precision by Newton's method.
    """
    lam = np.asarray(lam, dtype=np.complex128)
    damping, stiffness = gains.k_v * lam + gains.k_c, gains.k_d * lam
    if delay_s <= 0.0 and lag_s <= 0.0:
        return _quadratic(damping, stiffness)

    lines = delay_line(damping.ravel(), stiffness.ravel(), delay_s, lag_s)
    every = np.asarray(np.linalg.eigvals(lines).T.reshape(-1, *lam.shape), dtype=np.complex128)
    law = (damping, stiffness, delay_s, lag_s)
    # The fastest eigenvalues of the line are no roots.
    is_root = np.abs(_newton(every, *law)) < _NEAR * (1.0 + np.abs(every))
    order = np.argsort(np.where(is_root, -every.real, np.inf), axis=0, kind="stable")
    s: Complexes = np.take_along_axis(every, order[: 3 if lag_s > 0.0 else 2], axis=0)
    for _ in range(_NEWTON_STEPS):
        s = np.asarray(s - _newton(s, *law))
    return s


def _newton(
    s: Complexes, damping: Complexes, stiffness: Complexes, delay_s: float, lag_s: float
) -> Complexes:
    """Return by how much Newton's method changes approximate roots s."""
    law, late = damping * s + stiffness, np.exp(-s * delay_s)
    slope = 3.0 * lag_s * s * s + 2.0 * s + (damping - delay_s * law) * late
    value = (lag_s * s + 1.0) * s * s + law * late
    return np.asarray(value / np.where(slope == 0.0, 1.0, slope))


def _quadratic(linear: Complexes, constant: Complexes) -> Complexes:
    """Return the roots (2, ...) of s² + linear · s + constant, the one farther right first."""
    half = np.sqrt(linear * linear / 4.0 - constant + 0j)  # its real part is not negative
    return np.stack([-linear / 2.0 + half, -linear / 2.0 - half])


def modes(
    coupling: Coupling,
    gains: Gains,
    size: int,
    delay_s: float = 0.0,
    lag_s: float = 0.0,
    most: int | None = None,
) -> list[Mode]:
    """Return modes 1 .. size // 2 (or `most`) of a ring, each with its slowest root.

    The other modes are conjugates of these. Mode 0 shifts all vehicles alike, so it is left out.
    """
    last = size // 2 if most is None else min(most, size // 2)
    numbers = np.arange(1, last + 1)
    lam = eigenvalue(coupling, 2.0 * np.pi * numbers / size)
    slow = roots(lam, gains, delay_s, lag_s)[0]
    omega = np.where(np.abs(slow.imag) > _ROUNDING, np.abs(slow.imag), 0.0)
    return [
        Mode(int(n), float(rate), float(frequency))
        for n, rate, frequency in zip(numbers, slow.real, omega, strict=True)
    ]


def slowest_mode(
    coupling: Coupling, gains: Gains, size: int, delay_s: float = 0.0, lag_s: float = 0.0
) -> Mode:
    """Return the mode that decays slowest or grows fastest, and so dominates in the end."""
    return max(modes(coupling, gains, size, delay_s, lag_s), key=lambda mode: mode.rate)


def long_wave_speed(coupling: Coupling, gains: Gains) -> float:
    """Return the speed of long waves from vehicle to vehicle, backwards, vehicles/s.

    If one side has more weight, waves are kinematic: k_c (v - v_des) balances the gap's k_d, and
    their speed is k_d Σ j (ahead_j - behind_j) / k_c, which is infinite for k_c = 0. If both sides
    have the same weights, waves run both ways at √(k_d Σ j² c_j), as on a chain of springs. k_c
    damps them; below the θ at which λ k_d = k_c²/4 they do not oscillate.
    """
    lean = _moment(coupling.ahead, 1) - _moment(coupling.behind, 1)
    if lean != 0.0:
        return gains.k_d * lean / gains.k_c if gains.k_c > 0.0 else float("inf")
    both = _moment(coupling.ahead, 2) + _moment(coupling.behind, 2)
    return float(np.sqrt(gains.k_d * both / 2.0))


def wave_speeds(
    coupling: Coupling, gains: Gains, theta: float, delay_s: float = 0.0
) -> tuple[float, float]:
    """Return phase and group velocity of waves with phase θ per vehicle, backwards, vehicles/s.

    They follow from the dispersion relation ω(θ) = -Im s of the least damped wave, and are 0 where
    it does not oscillate.
    """
    step = 1e-4 * theta
    around = np.array([theta - step, theta, theta + step])
    slow = roots(eigenvalue(coupling, around), gains, delay_s)[0]
    # Symmetric couplings have pairs of waves that run both ways, in no fixed order.
    omega = np.abs(slow.imag) if coupling.ahead == coupling.behind else -slow.imag
    return float(omega[1] / theta), float((omega[2] - omega[0]) / (2.0 * step))


def _moment(weights: tuple[float, ...], power: int) -> float:
    return float(sum(weight * j**power for j, weight in enumerate(weights, start=1)))


def metres_per_second(vehicles_per_s: float, gap_m: float, speed_mps: float) -> float:
    """Return the speed over the road of a wave that runs backwards through the string, m/s."""
    return speed_mps - vehicles_per_s * gap_m
