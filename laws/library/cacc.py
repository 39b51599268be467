"""CACC with constant spacing, from radar and from reports of the vehicle ahead and the leader.

This is the law of PATH and Plexe: Rajamani, "Vehicle Dynamics and Control", 2nd ed., section 7.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from zenvoy.laws.law import Law, Needs, Observation
from zenvoy.laws.relative import Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Weight c1 of the leader, damping ratio xi ≥ 1, bandwidth omega_n (rad/s)."""

    c1: float = 0.5
    xi: float = 1.0
    omega_n: float = 0.2


def cooperative(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²."""
    c1, xi, omega_n = own.c1, own.xi, own.omega_n
    root = xi + math.sqrt(xi**2 - 1.0)
    return (
        (1.0 - c1) * seen.predecessor.a
        + c1 * seen.leader.a
        + (2.0 * xi - c1 * root) * omega_n * seen.ahead.v
        - c1 * root * omega_n * (seen.speed - seen.leader.v)
        + omega_n**2 * (seen.ahead.p - seen.setpoint.p_des)
    )


LAW = Law(
    name="CACC",
    acceleration=cooperative,
    parameters=Parameters,
    section="platoon",
    needs=Needs(predecessor=True, leader=True),
    mode=7,
    colour="#E69F00",
)
