"""ACC, adaptive cruise control with a constant time headway, from the host's radar alone.

Rajamani, "Vehicle Dynamics and Control", 2nd ed., Eq. 6.18, with a gap at standstill as in Plexe.
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.law import Law, Linear, Observation, Setpoint
from zenvoy.laws.parameters import NonNegative, Positive
from zenvoy.laws.relative import Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Time headway h (s), rate λ at which errors of the gap decay (1/s), gap at standstill (m).

    The gap at standstill is from bumper to bumper.
    """

    headway_s: Positive = 1.2
    lambda_per_s: Positive = 0.1
    standstill_m: NonNegative = 2.0


def constant_headway(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²: -(1/h)(dε/dt + λ δ) with δ = ε + h v.

    ε is minus the gap beyond the gap at standstill.
    """
    gap = seen.ahead.p - seen.length_m - own.standstill_m
    error = gap - own.headway_s * seen.speed
    return (seen.ahead.v + own.lambda_per_s * error) / own.headway_s


def _linear(own: Parameters, _: Setpoint, _m: int) -> Linear:
    h, rate = own.headway_s, own.lambda_per_s
    return Linear((1.0,), (), k_d=rate / h, k_v=1.0 / h, k_c=rate)


LAW = Law(
    name="ACC",
    acceleration=constant_headway,
    parameters=Parameters,
    keeps_gap=False,
    mode=8,
    colour="#332288",
    linear=_linear,
)
