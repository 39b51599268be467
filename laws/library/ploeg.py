"""Ploeg's CACC: a constant time headway, and the command of the vehicle ahead as feedforward.

Ploeg, Scheepers, van Nunen, van de Wouw and Nijmeijer (2011), "Design and experimental evaluation
of cooperative adaptive cruise control". The default parameters are those of Plexe.
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.arithmetic import known, where
from zenvoy.laws.law import Law, Needs, Observation, Output
from zenvoy.laws.parameters import NonNegative, Positive
from zenvoy.laws.relative import NAN, Number


@dataclass(frozen=True, slots=True)
class Parameters:
    """Gains k_p (s⁻²) and k_d (s⁻¹) of the gap's error, time headway h (s), gap at standstill (m).

    The gap at standstill is from bumper to bumper.
    """

    k_p: NonNegative = 0.2
    k_d: NonNegative = 0.7
    headway_s: Positive = 0.5
    standstill_m: NonNegative = 2.0


def feedback(seen: Observation, own: Parameters) -> Number:
    """Return k_p e + k_d de/dt, m/s², with the error e = gap - standstill - h v."""
    gap = seen.ahead.p - seen.length_m - own.standstill_m
    error = gap - own.headway_s * seen.speed
    rate = seen.ahead.v - own.headway_s * seen.acceleration
    return own.k_p * error + own.k_d * rate


def filtered(seen: Observation, own: Parameters, before: Number, wanted: Number) -> Number:
    """Return the command u of h du/dt = wanted - u after a period, m/s²; `before`: the last one.

    The step is Euler's, as in Plexe. A law that takes over starts at its own acceleration.
    """
    before = where(known(before), before, seen.acceleration)
    share = min(1.0, seen.period_s / own.headway_s)
    return before + share * (wanted - before)


def headway(seen: Observation, own: Parameters) -> Output:
    """Return the acceleration of the host, m/s², which is also the law's state."""
    (before,) = seen.state
    wanted = feedback(seen, own) + seen.predecessor.command
    command = filtered(seen, own, before, wanted)
    return Output(command, state=(command,))


LAW = Law(
    name="Ploeg",
    acceleration=headway,
    parameters=Parameters,
    needs=Needs(predecessor=True, commands=True),
    keeps_gap=False,
    state=(NAN,),
    mode=12,
    colour="#117733",
)
