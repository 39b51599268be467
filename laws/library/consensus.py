"""Consensus of a platoon on speed and distances, with the delay of each link made good.

Santini, Salvi, Valente, Pescapè, Segata and Lo Cigno (2017), "A consensus-based approach for
platooning with intervehicular communications and its validation in realistic scenarios". Links,
gains and spacing are those of Plexe, which takes the place of another vehicle from its last report
and its speed then.
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.arithmetic import where
from zenvoy.laws.law import Law, Needs, Observation
from zenvoy.laws.parameters import NonNegative
from zenvoy.laws.relative import Motion, Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Gains of the leader's speed (s⁻¹) and of distances (s⁻²), time headway (s), spacing (m).

    The gains of distances are those to the leader and to the vehicle ahead, and the one of a
    vehicle whose vehicle ahead is the leader. The spacing at standstill is from bumper to bumper.
    """

    speed_gain: NonNegative = 1.8
    leader_gain: NonNegative = 0.08
    ahead_gain: NonNegative = 0.86
    only_gain: NonNegative = 0.46
    headway_s: NonNegative = 0.8
    standstill_m: NonNegative = 15.0


def consensus(seen: Observation, own: Parameters) -> Number:
    """Return the acceleration of the host, m/s²; errors of distances count as their mean."""
    to_leader = _error(seen, seen.leader, own)
    to_both = own.leader_gain * to_leader + own.ahead_gain * _error(seen, seen.predecessor, own)
    is_second = seen.leader.steps == 1.0
    pull = where(is_second, own.only_gain * to_leader, 0.5 * to_both)
    return pull - own.speed_gain * (seen.speed - seen.leader.v)


def _error(seen: Observation, report: Motion, own: Parameters) -> Number:
    """Return by how much another vehicle is too far away now, m."""
    link = own.headway_s * seen.leader.v + own.standstill_m + seen.length_m
    return report.distance + report.age_s * report.v - report.steps * link


LAW = Law(
    name="Consensus",
    acceleration=consensus,
    parameters=Parameters,
    needs=Needs(predecessor=True, leader=True),
    keeps_gap=False,
    mode=14,
    colour="#AA4499",
)
