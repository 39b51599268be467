"""MBCM, multi-node bilateral control with m vehicles on each side.

See Wang and Horn, "Multinode bilateral control model".
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from zenvoy.laws.law import Law, Linear, Needs, Observation, Setpoint
from zenvoy.laws.relative import Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Number of vehicles on each side, and their weights c_1 .. c_m as a name or a list."""

    neighbours: int = 3
    weights: str | tuple[float, ...] = "least-squares"


@lru_cache(maxsize=64)
def weights_of(kind: str | tuple[float, ...], m: int) -> tuple[float, ...]:
    """Return c_1..c_m, nearest first: `least-squares` j² / Σ l², `uniform` 1 / m, or a given list.

    The first m of a given list are scaled to the sum of the list. So a shorter chain changes which
    vehicles count, but not how strongly the vehicle reacts.
    """
    if kind == "uniform":
        return (1.0 / m,) * m
    if isinstance(kind, str):
        total = m * (m + 1) * (2 * m + 1) / 6
        return tuple(j * j / total for j in range(1, m + 1))
    first = sum(kind[:m])
    share = sum(kind) / first if first > 0.0 else 0.0
    return tuple(weight * share for weight in kind[:m])


def multi_node(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s², from as many pairs of neighbours as are known."""
    k_d, k_v, k_c, _, v_des = seen.setpoint
    weights = weights_of(own.weights, len(seen.sides))
    pull = sum(
        c * (k_d * (ahead.p - behind.p) + k_v * (ahead.v - behind.v))
        for c, (ahead, behind) in zip(weights, seen.sides, strict=True)
    )
    return pull + k_c * (v_des - seen.speed)


def _linear(own: Parameters, setpoint: Setpoint, m: int) -> Linear:
    weights = weights_of(own.weights, m)
    return Linear(weights, weights, setpoint.k_d, setpoint.k_v, setpoint.k_c)


LAW = Law(
    name="MBCM",
    acceleration=multi_node,
    parameters=Parameters,
    section="multi_node",
    needs=Needs(sides="neighbours"),
    keeps_gap=False,
    mode=4,
    colour="#009E73",
    linear=_linear,
)
