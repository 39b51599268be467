"""FM, car following by gap and relative speed to the vehicle ahead (paper Eq. 1).

The paper prints k_c (v - v_des), which drives the speed away from v_des for k_c > 0. This module
uses k_c (v_des - v), as in Horn (2013), "Suppressing traffic flow instabilities".
"""

from __future__ import annotations

from zenvoy.laws.law import Law, Linear, NoParameters, Observation, Setpoint
from zenvoy.laws.relative import Number


def following(seen: Observation, _: object = None) -> Number:
    """Return the acceleration of the host, m/s² (paper Eq. 1)."""
    k_d, k_v, k_c, p_des, v_des = seen.setpoint
    return k_d * (seen.ahead.p - p_des) + k_v * seen.ahead.v + k_c * (v_des - seen.speed)


def _linear(_: NoParameters, setpoint: Setpoint, _m: int) -> Linear:
    return Linear((1.0,), (), setpoint.k_d, setpoint.k_v, setpoint.k_c)


LAW = Law(name="FM", acceleration=following, mode=2, colour="#000000", linear=_linear)
