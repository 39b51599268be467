"""Linear theory of a string of vehicles, each under its own law, driven by one of them.

Vehicle i obeys s² x_i = L_i [Σ_j w_ij (k_v s + k_d) (x_j - x_i) - k_c s x_i], except for the
source, whose motion is given. L_i = e^(-sτ_i) / (T_i s + 1) is the delay of its commands and the
lag of its actuator. Each frequency gives a system of linear equations. The ratios between
vehicles are the same for positions and speeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from zenvoy.analysis.theory.laws import FM, Complexes, Coupling, Floats, lateness
from zenvoy.analysis.theory.ring import roots
from zenvoy.scenarios import Gains

_BATCH: Final = 256  # frequencies solved at once, with a matrix each
_MAX_OMEGA: Final = 10.0  # rad/s; no law with sensible gains transmits faster motion


class Member(NamedTuple):
    """The law and gains of a vehicle, the delay of its commands and the lag of its actuator, s.

    If `coupling` is None, it keeps its speed.
    """

    coupling: Coupling | None
    gains: Gains
    delay_s: float
    lag_s: float = 0.0


def open_road(members: Sequence[Member]) -> list[Member]:
    """Return the string of paper Eq. 3_2: vehicle 1 keeps its speed, vehicle N runs FM.

    `members` are vehicles 1..N as they would be on a ring; the laws of the first and last one are
    ignored. A vehicle near an end counts as many neighbours on both sides as the shorter side has.
    """
    n = len(members)
    inside = [
        member._replace(coupling=_at(i, n, member.coupling))
        for i, member in enumerate(members[1:-1], start=1)
    ]
    return [members[0]._replace(coupling=None), *inside, members[-1]._replace(coupling=FM)]


def _at(i: int, n: int, coupling: Coupling | None) -> Coupling | None:
    if coupling is None:
        return None
    room = min(i, n - 1 - i) if coupling.behind else i
    return Coupling(_shorter(coupling.ahead, room), _shorter(coupling.behind, room))


def _shorter(weights: tuple[float, ...], room: int) -> tuple[float, ...]:
    """Return the first `room` weights, scaled to the sum of all: the weights of a smaller m."""
    kept = weights[:room]
    share = sum(weights) / sum(kept) if sum(kept) > 0.0 else 0.0
    return tuple(weight * share for weight in kept)


def is_stable(members: Sequence[Member]) -> bool:
    """Return whether the string comes to rest by itself, so that its frequency response exists.

    Delay and lag destabilise the fastest motion first, in which neighbours move against each other.
    It has λ = 2 Σ weights. Under a law that looks only ahead, all motions have λ = Σ weights.
    """
    for coupling, gains, delay_s, lag_s in set(members):
        if coupling is None:
            continue
        weight = sum(coupling.ahead) + sum(coupling.behind)
        lam = np.array([2.0 * weight if coupling.behind else weight], dtype=np.complex128)
        if roots(lam, gains, delay_s, lag_s)[0, 0].real > 0.0:
            return False
        if coupling.behind and gains.k_c < 0.0:  # long waves grow
            return False
    return True


def frequency_response(
    omega: Floats, members: Sequence[Member], source: int, *, ring: bool
) -> Complexes:
    """Return every vehicle's speed over that of the vehicle with index `source`, (F, n).

    The frequencies ω (F,) are in rad/s.

    On a `ring` the last vehicle is ahead of the first. k_d must be positive where ω contains 0.
    """
    omega = np.asarray(omega, dtype=np.float64)
    parts = [
        _solve(omega[k : k + _BATCH], members, source, ring) for k in range(0, len(omega), _BATCH)
    ]
    return np.concatenate(parts)


def follow(
    motion: Floats,
    period_s: float,
    members: Sequence[Member],
    source: int,
    *,
    ring: bool,
) -> Floats:
    """Return the deviations of all vehicles' speeds (T, n) caused by that of the source (T,), m/s.

    `motion` begins at 0. The spectrum covers three times its length, so that the response has died
    out before the period of the Fourier transform ends.
    """
    steps = 1 << int(np.ceil(np.log2(3 * len(motion))))
    omega = np.asarray(2.0 * np.pi * np.fft.rfftfreq(steps, period_s), dtype=np.float64)
    slow = omega <= _MAX_OMEGA
    spectrum = np.zeros((len(omega), len(members)), dtype=np.complex128)
    response = frequency_response(omega[slow], members, source, ring=ring)
    spectrum[slow] = response * np.fft.rfft(motion, steps)[slow, None]
    moved = np.fft.irfft(spectrum, steps, axis=0)[: len(motion)]
    moved[:, source] = motion
    return np.asarray(moved)


def _solve(omega: Floats, members: Sequence[Member], source: int, ring: bool) -> Complexes:
    n = len(members)
    s = 1j * omega
    matrix = np.zeros((len(omega), n, n), dtype=np.complex128)
    for i, (coupling, gains, delay_s, lag_s) in enumerate(members):
        if i == source or coupling is None:
            matrix[:, i, i] = 1.0
            continue
        late = lateness(omega, delay_s, lag_s)
        matrix[:, i, i] += s * s + gains.k_c * s * late
        pull = (gains.k_v * s + gains.k_d) * late
        for j, weight in _neighbours(i, n, coupling, ring):
            matrix[:, i, i] += weight * pull
            matrix[:, i, j] -= weight * pull
    moved = np.zeros((len(omega), n, 1), dtype=np.complex128)
    moved[:, source] = 1.0
    return np.asarray(np.linalg.solve(matrix, moved)[:, :, 0])


def _neighbours(i: int, n: int, coupling: Coupling, ring: bool) -> list[tuple[int, float]]:
    """Return index and weight of each neighbour that vehicle `i` counts."""
    found = [(i - j, weight) for j, weight in enumerate(coupling.ahead, start=1)]
    found += [(i + j, weight) for j, weight in enumerate(coupling.behind, start=1)]
    if ring:
        return [(j % n, weight) for j, weight in found]
    return [(j, weight) for j, weight in found if 0 <= j < n]
