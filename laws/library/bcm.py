"""BCM, bilateral control: the vehicles ahead and behind have the same weight (paper Eq. 2)."""

from __future__ import annotations

from zenvoy.laws.law import Law, Linear, Needs, NoParameters, Observation, Setpoint
from zenvoy.laws.relative import Number


def bilateral(seen: Observation, _: object = None) -> Number:
    """Return the acceleration of the host, m/s² (paper Eq. 2). It has no desired gap."""
    k_d, k_v, k_c, _, v_des = seen.setpoint
    ahead, behind = seen.ahead, seen.behind
    return k_d * (ahead.p - behind.p) + k_v * (ahead.v - behind.v) + k_c * (v_des - seen.speed)


def linear(_: NoParameters, setpoint: Setpoint, _m: int) -> Linear:
    """Return the law itself, because it is linear."""
    return Linear((1.0,), (1.0,), setpoint.k_d, setpoint.k_v, setpoint.k_c)


LAW = Law(
    name="BCM",
    acceleration=bilateral,
    needs=Needs(behind=True),
    keeps_gap=False,
    mode=3,
    colour="#D55E00",
    linear=linear,
)
