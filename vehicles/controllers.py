"""The control laws, as functions of relative states.

The paper prints k_c (v - v_des), which for k_c > 0 drives the speed away from v_des; we use
k_c (v_des - v) as in Horn (2013), "Suppressing traffic flow instabilities".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from zenvoy.vehicles.relative import Relative


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatoonLaw:
    """Weight c1 of the leader, damping ratio xi ≥ 1, bandwidth omega_n (rad/s)."""

    c1: float = 0.5
    xi: float = 1.0
    omega_n: float = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """Gains k_d (s⁻²), k_v and k_c (s⁻¹), desired gap (m) and speed (m/s), limit (m/s²).

    `weights` are those of MBCM, by name or nearest first; `platoon` is for CACC. `cruise` is how
    fast (m/s²) the desired speed of one who has nobody ahead changes; None: it keeps its speed.
    """

    k_d: float
    k_v: float
    k_c: float
    p_des: float
    v_des: float
    a_max: float
    weights: str | tuple[float, ...] = "least-squares"
    platoon: PlatoonLaw = PlatoonLaw()
    cruise: float | None = None


class Told(NamedTuple):
    """What another vehicle's beacon says of its motion: speed (m/s) and acceleration (m/s²)."""

    v: float
    a: float


def following(ahead: Relative, v: float, law: Law) -> float:
    """FM: acceleration of the host, m/s² (paper Eq. 1)."""
    return law.k_d * (ahead.p - law.p_des) + law.k_v * ahead.v + law.k_c * (law.v_des - v)


def bilateral(ahead: Relative, behind: Relative, v: float, law: Law) -> float:
    """BCM: acceleration of the host, m/s² (paper Eq. 2); PBCM applies it to predictions (Eq. 8)."""
    return (
        law.k_d * (ahead.p - behind.p) + law.k_v * (ahead.v - behind.v) + law.k_c * (law.v_des - v)
    )


def multi_node(
    sides: Sequence[tuple[Relative, Relative]], weights: Sequence[float], v: float, law: Law
) -> float:
    """MBCM: acceleration of the host, m/s² (Wang and Horn, "Multinode bilateral control model").

    `sides`: the state relative to the j-th vehicle ahead and of the j-th behind, j = 1..m, each
    over the whole distance; `weights` c_1..c_m.
    """
    pull = sum(
        c * (law.k_d * (ahead.p - behind.p) + law.k_v * (ahead.v - behind.v))
        for c, (ahead, behind) in zip(weights, sides, strict=True)
    )
    return pull + law.k_c * (law.v_des - v)


@lru_cache(maxsize=64)
def multi_node_weights(kind: str | tuple[float, ...], m: int) -> tuple[float, ...]:
    """c_1..c_m, nearest first: `least-squares` j² / Σ l², `uniform` 1 / m, or the given ones.

    Of given ones the first m count, in the same proportions and with the same sum, so that a
    chain that breaks changes who is heard and not how hard the vehicle reacts.
    """
    if kind == "uniform":
        return (1.0 / m,) * m
    if isinstance(kind, str):
        total = m * (m + 1) * (2 * m + 1) / 6
        return tuple(j * j / total for j in range(1, m + 1))
    first = sum(kind[:m])
    share = sum(kind) / first if first > 0.0 else 0.0
    return tuple(weight * share for weight in kind[:m])


def cooperative(ahead: Relative, told: Told, leader: Told, v: float, law: Law) -> float:
    """CACC with constant spacing: acceleration of the host, m/s².

    Rajamani, "Vehicle Dynamics and Control" (2nd ed., section 7.5; PATH's law, the CACC of Plexe),
    from the vehicle ahead, what it told, and what the leader of the platoon told.
    """
    c1, xi, omega_n = law.platoon.c1, law.platoon.xi, law.platoon.omega_n
    root = xi + math.sqrt(xi**2 - 1.0)
    return (
        (1.0 - c1) * told.a
        + c1 * leader.a
        + (2.0 * xi - c1 * root) * omega_n * ahead.v
        - c1 * root * omega_n * (v - leader.v)
        + omega_n**2 * (ahead.p - law.p_des)
    )


def cruising(v: float, law: Law) -> float:
    """Acceleration of a vehicle with nobody ahead, m/s².

    0, as the paper's Eq. 5 has it; or, once it has been given a desired speed, what is left of
    FM, with the rate of that speed fed forward, so that a ramp is followed whatever k_c is.
    """
    return 0.0 if law.cruise is None else law.cruise + law.k_c * (law.v_des - v)


def limited(a: float, law: Law) -> float:
    """Acceleration within the comfort limit of ±a_max (paper Section IV)."""
    return max(-law.a_max, min(law.a_max, a))
