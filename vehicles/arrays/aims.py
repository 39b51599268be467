"""The desired values of every vehicle, as the schedule sets them over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from zenvoy.laws import Setpoint
from zenvoy.scenarios import Settings
from zenvoy.vehicles.arrays.rows import Floats


class Aims(NamedTuple):
    """The desired values of every vehicle.

    cruise is that of `decision.Aim`, m/s²; it is NaN for a vehicle without one.
    """

    setpoint: Setpoint
    cruise: Floats


class Schedule:
    """The aims over time of the vehicles with these settings, in order."""

    def __init__(self, settings: Sequence[Settings]) -> None:
        distinct = {one.targets: None for one in settings}
        self._targets = list(distinct)
        number = {targets: at for at, targets in enumerate(self._targets)}
        self._which = np.array([number[one.targets] for one in settings])
        self._constant: Aims | None = None
        if not any(targets.change for targets in self._targets):
            self._constant = self._at(0)

    def at(self, now_ns: int) -> Aims:
        """Return the aims at an instant."""
        return self._at(now_ns) if self._constant is None else self._constant

    def _at(self, now_ns: int) -> Aims:
        rows = []
        for targets in self._targets:
            cruises = targets.cruises_ns is not None and targets.cruises_ns <= now_ns
            rows.append(
                (
                    targets.k_d.at(now_ns),
                    targets.k_v.at(now_ns),
                    targets.k_c.at(now_ns),
                    targets.desired_gap_m.at(now_ns),
                    targets.desired_speed_mps.at(now_ns),
                    targets.desired_speed_mps.rate(now_ns) if cruises else np.nan,
                )
            )
        columns = np.array(rows).T[:, self._which]
        return Aims(Setpoint(*columns[:5]), columns[5])
