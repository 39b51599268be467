"""Ploeg's loop without V2V: its adaptive cruise control."""

from __future__ import annotations

from zenvoy.laws import Law, Observation, Output
from zenvoy.laws.library import ploeg
from zenvoy.laws.relative import NAN


def alone(seen: Observation, own: ploeg.Parameters) -> Output:
    """Return the acceleration of the host, m/s², which is also the law's state."""
    (before,) = seen.state
    command = ploeg.filtered(seen, own, before, ploeg.feedback(seen, own))
    return Output(command, state=(command,))


LAW = Law(
    name="Ploeg alone",
    acceleration=alone,
    parameters=ploeg.Parameters,
    keeps_gap=False,
    state=(NAN,),
    colour="#999933",
)
