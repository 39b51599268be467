"""SPBCM: PBCM on estimates that both vehicles of a link share, and without a fallback.

docs/beyond-the-paper.md explains the law and compares it with PBCM.
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.arithmetic import known, larger, where
from zenvoy.laws.law import Law, Linear, Needs, Observation, Setpoint
from zenvoy.laws.library.bcm import bilateral
from zenvoy.laws.parameters import Positive
from zenvoy.laws.relative import Number, Relative


@dataclass(frozen=True, slots=True)
class Parameters:
    """Age (s) from which on the data of the vehicle behind do not count."""

    patience_s: Positive = 40.0


def shared(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s².

    The older the data of the vehicle behind, the less they count, and the more the desired gap does
    in their place. So BCM (paper Eq. 2) turns into FM (Eq. 1) while nothing is heard from behind.
    """
    p_des, age_s = seen.setpoint.p_des, seen.behind_age_s
    heard = known(age_s)
    weight = where(heard, larger(0.0, 1.0 - where(heard, age_s, 0.0) / own.patience_s), 0.0)
    p, v = where(heard, seen.behind.p, p_des), where(heard, seen.behind.v, 0.0)
    behind = Relative(p_des + weight * (p - p_des), weight * v)
    return bilateral(seen._replace(behind=behind))


def _linear(_: Parameters, setpoint: Setpoint, _m: int) -> Linear:
    """Return the law while the vehicle behind is heard."""
    return Linear((1.0,), (1.0,), setpoint.k_d, setpoint.k_v, setpoint.k_c)


LAW = Law(
    name="SPBCM",
    acceleration=shared,
    parameters=Parameters,
    needs=Needs(behind=True, prediction=True, shares_links=True, tolerates_silence=True),
    keeps_gap=True,
    mode=18,
    colour="#BB5566",
    linear=_linear,
)
