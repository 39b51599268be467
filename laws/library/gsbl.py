"""GSBL, the flatbed tow truck: gaps of a platoon whose vehicles know the speed of its leader.

Ali, Garcia and Martinet (2015), "The flatbed platoon towing model for safe and dense platooning on
highways". The vehicles are towed, as it were, on a flatbed that drives at the speed of the leader.
So the headway applies to the speed relative to the leader alone. The default parameters are those
of Plexe, which names this law FLATBED.
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.law import Law, Needs, Observation
from zenvoy.laws.parameters import NonNegative
from zenvoy.laws.relative import Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Gains of acceleration k_a, speed k_v (s⁻¹) and gap k_p (s⁻²), headway h (s), gap (m).

    The gap at the speed of the leader is from bumper to bumper.
    """

    k_a: NonNegative = 2.4
    k_v: NonNegative = 0.6
    k_p: NonNegative = 12.0
    headway_s: NonNegative = 4.0
    spacing_m: NonNegative = 5.0


def towed(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²."""
    error = seen.ahead.p - seen.length_m - own.spacing_m
    error = error - own.headway_s * (seen.speed - seen.leader.v)
    return -own.k_a * seen.acceleration + own.k_v * seen.ahead.v + own.k_p * error


LAW = Law(
    name="GSBL",
    acceleration=towed,
    parameters=Parameters,
    needs=Needs(leader=True),
    keeps_gap=False,
    mode=15,
    colour="#661100",
)
