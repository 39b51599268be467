"""The control laws, as functions of relative states.

The paper prints k_c (v - v_des), which for k_c > 0 drives the speed away from v_des; we use
k_c (v_des - v) as in Horn (2013), "Suppressing traffic flow instabilities".
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.vehicles.relative import Relative


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """Gains k_d (s⁻²), k_v and k_c (s⁻¹), desired gap (m) and speed (m/s), limit (m/s²)."""

    k_d: float
    k_v: float
    k_c: float
    p_des: float
    v_des: float
    a_max: float


def following(ahead: Relative, v: float, law: Law) -> float:
    """FM: acceleration of the host, m/s² (paper Eq. 1)."""
    return law.k_d * (ahead.p - law.p_des) + law.k_v * ahead.v + law.k_c * (law.v_des - v)


def bilateral(ahead: Relative, behind: Relative, v: float, law: Law) -> float:
    """BCM: acceleration of the host, m/s² (paper Eq. 2); PBCM applies it to predictions (Eq. 8)."""
    return (
        law.k_d * (ahead.p - behind.p) + law.k_v * (ahead.v - behind.v) + law.k_c * (law.v_des - v)
    )


def limited(a: float, law: Law) -> float:
    """Acceleration within the comfort limit of ±a_max (paper Section IV)."""
    return max(-law.a_max, min(law.a_max, a))
