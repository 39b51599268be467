"""IDM, the Intelligent Driver Model of a human driver.

Treiber, Hennecke and Helbing (2000), "Congested traffic states in empirical observations and
microscopic simulations". The desired gap is never below s0, and the default parameters are those of
highway traffic, both as in Treiber and Kesting (2013), "Traffic Flow Dynamics", chapter 11.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from zenvoy.laws.arithmetic import larger, power, root
from zenvoy.laws.law import Law, Linear, Observation, Setpoint
from zenvoy.laws.parameters import Exponent, NonNegative, Positive
from zenvoy.laws.relative import Number

_SMALLEST_GAP_M: Final = 0.1  # at a smaller gap the driver brakes as at this one


@dataclass(frozen=True, slots=True)
class Parameters:
    """The letters of the model: v0 (m/s), T (s), s0 (m), a and b (m/s²), δ.

    They are the speed on a free road, the time headway, the gap at standstill from bumper to
    bumper, the acceleration, the comfortable deceleration, and the exponent of the acceleration.
    """

    free_speed_mps: Positive = 33.3
    headway_s: NonNegative = 1.0
    standstill_m: Positive = 2.0
    acceleration_mps2: Positive = 1.0
    deceleration_mps2: Positive = 1.5
    exponent: Exponent = 4


def intelligent_driver(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²: a (1 - (v / v0)^δ - (s* / s)²)."""
    v, a = seen.speed, own.acceleration_mps2
    braking = 2.0 * root(a * own.deceleration_mps2)
    approach = own.headway_s * v - v * seen.ahead.v / braking
    wanted = own.standstill_m + larger(0.0, approach)
    gap = larger(_SMALLEST_GAP_M, seen.ahead.p - seen.length_m)
    ratio = wanted / gap
    return a * (1.0 - power(v / own.free_speed_mps, own.exponent) - ratio * ratio)


def equilibrium_gap_m(own: Parameters, speed_mps: float) -> float:
    """Return the equilibrium gap from bumper to bumper at a steady speed, m; ∞ from v0 on."""
    free = 1.0 - power(speed_mps / own.free_speed_mps, own.exponent)
    wanted = own.standstill_m + own.headway_s * speed_mps
    return wanted / math.sqrt(free) if free > 0.0 else math.inf


def stable_acceleration_mps2(own: Parameters, speed_mps: float) -> float:
    """Return the smallest a with which a string of such drivers damps every frequency, m/s².

    At an equilibrium, k_c² / 2 + k_v k_c ≥ k_d (Treiber and Kesting 2013, chapter 15). `own` gives
    all parameters but a. Divided by a, the condition is quadratic in √a. At rest, a is s0 / T².
    """
    _, _, k_d, k_v, k_c = _at(replace(own, acceleration_mps2=1.0), speed_mps)
    if k_c <= 0.0:
        return math.inf
    root_a = (math.sqrt(k_v * k_v + 2.0 * k_d) - k_v) / k_c
    return root_a * root_a


def _at(own: Parameters, v: float) -> Linear:
    """Return the derivatives of the law at the equilibrium of a speed; k_d is 0 from v0 on."""
    a, gap = own.acceleration_mps2, equilibrium_gap_m(own, v)
    wanted = own.standstill_m + own.headway_s * v
    slope = power(v / own.free_speed_mps, own.exponent - 1) * own.exponent / own.free_speed_mps
    return Linear(
        (1.0,),
        (),
        k_d=2.0 * a * (wanted / gap) ** 2 / gap,
        k_v=math.sqrt(a / own.deceleration_mps2) * v * wanted / gap**2,
        k_c=a * (slope + 2.0 * own.headway_s * wanted / gap**2),
    )


def _linear(own: Parameters, setpoint: Setpoint, _m: int) -> Linear:
    """Return the law at the equilibrium of the desired speed of the scenario."""
    return _at(own, setpoint.v_des)


LAW = Law(
    name="IDM",
    acceleration=intelligent_driver,
    parameters=Parameters,
    keeps_gap=False,
    mode=9,
    colour="#882255",
    linear=_linear,
)
