"""PF-CACC, connected cruise control with predictor feedback, which makes up for the delay.

Molnár, Qin, Insperger and Orosz (2018), "Application of predictor feedback to compensate time
delays in connected cruise control". The law acts on the states predicted to the instant at which
its command takes effect; the motion of the vehicle ahead comes by V2V.
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.arithmetic import larger, smaller
from zenvoy.laws.law import Law, Linear, Needs, Observation, Setpoint
from zenvoy.laws.parameters import NonNegative, Positive
from zenvoy.laws.relative import Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Gains α and β (1/s), slope κ of the range policy (1/s), its gap at standstill and top speed.

    The gap at standstill is from bumper to bumper, m. Without delay the law is string stable if
    α + 2 β ≥ 2 κ.
    """

    alpha_per_s: Positive = 0.4
    beta_per_s: NonNegative = 0.5
    kappa_per_s: Positive = 0.6
    standstill_m: NonNegative = 5.0
    free_speed_mps: Positive = 33.3


def connected(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²: α (V(h) - v) + β (W(v_1) - v).

    V is κ (h - h_0) within [0, v_max], and W is the speed of the vehicle ahead up to v_max.
    """
    v, gap = seen.speed, seen.ahead.p - seen.length_m
    wanted = smaller(own.free_speed_mps, larger(0.0, own.kappa_per_s * (gap - own.standstill_m)))
    leader = smaller(own.free_speed_mps, v + seen.ahead.v)
    return own.alpha_per_s * (wanted - v) + own.beta_per_s * (leader - v)


def _linear(own: Parameters, setpoint: Setpoint, _m: int) -> Linear:
    """Return the law at the equilibrium of the desired speed; it follows nobody from v_max on."""
    alpha, beta = own.alpha_per_s, own.beta_per_s
    if setpoint.v_des >= own.free_speed_mps:
        return Linear((1.0,), (), k_d=0.0, k_v=0.0, k_c=alpha + beta)
    return Linear((1.0,), (), k_d=alpha * own.kappa_per_s, k_v=beta, k_c=alpha)


LAW = Law(
    name="PF-CACC",
    acceleration=connected,
    parameters=Parameters,
    needs=Needs(prediction=True),
    keeps_gap=False,
    mode=17,
    colour="#6699CC",
    linear=_linear,
)
