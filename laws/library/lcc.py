"""LCC, leading cruise control: follows the vehicle ahead, and leads the human drivers behind it.

Wang, Zheng, Chen, Xu and Li (2022), "Leading cruise control in mixed traffic flow: system modeling,
controllability, and string stability". The gains are those of their section V. The own dynamics are
their optimal velocity model, linearised at 15 m/s and 20 m.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from zenvoy.laws.law import Law, Needs, Observation
from zenvoy.laws.parameters import Finite, Sides
from zenvoy.laws.relative import Number, Relative


@dataclass(frozen=True, slots=True)
class Parameters:
    """Number of vehicles on each side, gains α of the own dynamics, μ and k of each other vehicle.

    α_1 (s⁻²) is that of the own gap, α_2 (s⁻¹) of the own speed, α_3 (s⁻¹) of the speed ahead. μ
    (s⁻²) is that of the gap that another vehicle keeps, and k (s⁻¹) that of its speed.
    """

    vehicles: Sides = 2
    alpha_1: Finite = 0.942
    alpha_2: Finite = 1.5
    alpha_3: Finite = 0.9
    mu_ahead: Finite = 1.0
    k_ahead: Finite = -1.0
    mu_behind: Finite = -1.0
    k_behind: Finite = -1.0


def leading(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²: α_1 s - α_2 v + α_3 v_(-1) + Σ (μ s_j + k v_j).

    Speeds and gaps count from the desired ones. With m vehicles known on each side, the sum is over
    m - 1 vehicles ahead, as the gap of the m-th is not known, and over m behind.
    """
    p_des, v_des = seen.setpoint.p_des, seen.setpoint.v_des
    own_v = seen.speed - v_des
    a = own.alpha_1 * (seen.ahead.p - p_des) - own.alpha_2 * own_v
    a = a + own.alpha_3 * (own_v + seen.ahead.v)
    for near, far in pairwise(ahead for ahead, _ in seen.sides):
        a = a + own.mu_ahead * (far.p - near.p - p_des) + own.k_ahead * (own_v + near.v)
    for near, far in pairwise((Relative(0.0, 0.0), *(behind for _, behind in seen.sides))):
        a = a + own.mu_behind * (far.p - near.p - p_des) + own.k_behind * (own_v - far.v)
    return a


LAW = Law(
    name="LCC",
    acceleration=leading,
    parameters=Parameters,
    needs=Needs(sides="vehicles"),
    mode=16,
    colour="#EE3377",
)
