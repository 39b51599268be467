"""FollowerStopper: drives at a desired speed, and slower only where the gap demands it.

Stern et al. (2018), "Dissipation of stop-and-go waves via control of autonomous vehicles: Field
experiments", section 3.1. In the field the speed went to the car's own controller of speed, which
the paper does not give; here the vehicle approaches it with a time constant.
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.arithmetic import larger, share, smaller
from zenvoy.laws.law import Law, Observation
from zenvoy.laws.parameters import Positive
from zenvoy.laws.relative import Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Gaps Δx_k⁰ (m) and decelerations d_k (m/s²) of the three boundaries, as in the experiment.

    tracking_s is the time constant with which the vehicle takes on the commanded speed.
    """

    gap_1_m: Positive = 4.5
    gap_2_m: Positive = 5.25
    gap_3_m: Positive = 6.0
    d_1_mps2: Positive = 1.5
    d_2_mps2: Positive = 1.0
    d_3_mps2: Positive = 0.5
    tracking_s: Positive = 0.5

    def __post_init__(self) -> None:
        if not self.gap_1_m < self.gap_2_m < self.gap_3_m:
            raise ValueError("gap_1_m, gap_2_m and gap_3_m must increase")
        if not self.d_1_mps2 >= self.d_2_mps2 >= self.d_3_mps2:
            raise ValueError("d_1_mps2, d_2_mps2 and d_3_mps2 must not increase")


def commanded_speed(seen: Observation, own: Parameters) -> Number:
    """Return the speed to drive at, m/s (Eqs. 1 and 2), where U is the desired speed.

    Between the boundaries it rises linearly with the gap: from 0 to the speed of the vehicle ahead,
    and from that to U.
    """
    closing, wanted = smaller(seen.ahead.v, 0.0), seen.setpoint.v_des
    gap, square = seen.ahead.p - seen.length_m, closing * closing
    first = own.gap_1_m + square / (2.0 * own.d_1_mps2)
    second = own.gap_2_m + square / (2.0 * own.d_2_mps2)
    third = own.gap_3_m + square / (2.0 * own.d_3_mps2)
    leader = smaller(larger(seen.speed + seen.ahead.v, 0.0), wanted)
    return leader * share(gap, first, second) + (wanted - leader) * share(gap, second, third)


def stopping(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²."""
    return (commanded_speed(seen, own) - seen.speed) / own.tracking_s


LAW = Law(
    name="FollowerStopper",
    acceleration=stopping,
    parameters=Parameters,
    keeps_gap=False,
    mode=10,
    colour="#44AA99",
)
