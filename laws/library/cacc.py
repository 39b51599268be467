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
    """Weight c1 of the leader, damping ratio xi ≥ 1, bandwidth omega_n (rad/s).

    commanded: whether the accelerations fed forward are the newest commands of the others, and not
    the accelerations that act. reported_speed: whether the speed of the vehicle ahead is the one
    that it reports, and not the one by radar. In Plexe both are so.
    """

    c1: float = 0.5
    xi: float = 1.0
    omega_n: float = 0.2
    commanded: bool = False
    reported_speed: bool = False


def cooperative(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²."""
    c1, xi, omega_n = own.c1, own.xi, own.omega_n
    root = xi + math.sqrt(xi**2 - 1.0)
    ahead, leader = seen.predecessor, seen.leader
    fed = (ahead.command, leader.command) if own.commanded else (ahead.a, leader.a)
    relative_speed = ahead.v - seen.speed if own.reported_speed else seen.ahead.v
    return (
        (1.0 - c1) * fed[0]
        + c1 * fed[1]
        + (2.0 * xi - c1 * root) * omega_n * relative_speed
        - c1 * root * omega_n * (seen.speed - leader.v)
        + omega_n**2 * (seen.ahead.p - seen.setpoint.p_des)
    )


LAW = Law(
    name="CACC",
    acceleration=cooperative,
    parameters=Parameters,
    section="platoon",
    needs=Needs(predecessor=True, leader=True, commands="commanded"),
    mode=7,
    colour="#E69F00",
)
