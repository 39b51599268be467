"""dCACC: Ploeg's CACC that estimates the acceleration of the vehicle ahead if it hears nothing.

Ploeg, Semsar-Kazerooni, Lijster, van de Wouw and Nijmeijer (2015), "Graceful degradation of
cooperative adaptive cruise control".
"""

from __future__ import annotations

from dataclasses import dataclass

from zenvoy.laws.arithmetic import known, where
from zenvoy.laws.law import Column, Law, Needs, Observation, Output
from zenvoy.laws.library import ploeg
from zenvoy.laws.parameters import Positive
from zenvoy.laws.relative import NAN
from zenvoy.laws.singer import Singer, Track, corrected, predicted, steady_gains


@dataclass(frozen=True, slots=True)
class Parameters(ploeg.Parameters):
    """Those of Ploeg, and those of Singer's model with the errors of the radar.

    The standard deviation of the acceleration, √2.82 m/s², is Singer's for at most 3 m/s² in 1 % of
    the time each way, and none in 10 %.
    """

    manoeuvre_s: Positive = 0.8
    acceleration_std_mps2: Positive = 1.68
    gap_std_m: Positive = 0.17
    speed_std_mps: Positive = 0.13


def graceful(seen: Observation, own: Parameters) -> Output:
    """Return the acceleration of the host, m/s², and the estimated one of the vehicle ahead."""
    before, *tracked = seen.state
    track = _track(seen, Track._make(tracked), own)
    heard = seen.predecessor.command
    wanted = ploeg.feedback(seen, own) + where(known(heard), heard, track.a)
    command = ploeg.filtered(seen, own, before, wanted)
    return Output(command, logged=(track.a,), state=(command, *track))


def _track(seen: Observation, before: Track, own: Parameters) -> Track:
    """Return the track of the vehicle ahead, which begins at the first reading of the radar."""
    model = Singer(own.manoeuvre_s, own.acceleration_std_mps2, own.gap_std_m, own.speed_std_mps)
    then = predicted(before, seen.acceleration, model, seen.period_s)
    now = corrected(then, seen.ahead, steady_gains(model, seen.period_s))
    starts = Track(seen.ahead.p, seen.ahead.v, 0.0 * seen.ahead.p)
    goes_on = known(before.p)
    return Track._make(where(goes_on, one, first) for one, first in zip(now, starts, strict=True))


LAW = Law(
    name="dCACC",
    acceleration=graceful,
    parameters=Parameters,
    needs=Needs(predecessor=True, commands=True, tolerates_silence=True),
    keeps_gap=False,
    columns=(Column("acceleration_ahead", "m/s²"),),
    state=(NAN, NAN, NAN, NAN),
    mode=13,
    colour="#CC6677",
)
