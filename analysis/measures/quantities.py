"""Aligns what vehicles measure and estimate with the truth at the same instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.spans import first_disturbance
from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """One quantity of every vehicle; arrays (cycles, vehicles), NaN where there is no value.

    Row k is the start of cycle k in all arrays. The estimate of a link stands in the row of its
    newest reading, and appears once. `std` is the standard deviation that the filter states,
    `reading_variance` the true variance of `measured` around the truth.
    """

    name: str
    unit: str
    true: Floats
    measured: Floats
    estimated: Floats
    std: Floats
    reading_variance: Floats
    filters_reading: bool
    """Whether the filter's input is `measured`; False where it compares positions instead."""

    @property
    def label(self) -> str:
        """Name and unit, for axes and tables."""
        return f"{self.name}, {self.unit}"

    @property
    def error(self) -> Floats:
        """The error of the estimate, in `unit`."""
        return self.estimated - self.true


def quantities(run: Run) -> tuple[Quantity, ...]:
    """Return own speed, then gap and relative speed of the links ahead and behind.

    The result is empty where no cycle was logged. The link behind is measured by the radar of the
    vehicle behind, which reports it (paper Section III).
    """
    if not run.cycles:
        return ()
    n, ring_m, cycles = run.vehicles, run.scenario.ring_length_m, run.cycles
    speed = run.truth["speed"][:cycles]
    gap = gaps(run.truth["position"][:cycles], ring_m)
    front = np.where(np.isnan(gap), np.nan, np.roll(speed, 1, axis=1))
    share = run.scenario.sensors.error_std
    by_radar = run.scenario.control.neighbour_state == "radar"
    radar, estimate = run.radar, run.estimate
    own = Quantity(
        name="own speed",
        unit="m/s",
        true=speed,
        measured=radar["speed"][:cycles],
        estimated=estimate["speed"][:cycles],
        std=estimate["speed_std"][:cycles],
        reading_variance=(share * speed) ** 2,
        filters_reading=True,
    )
    found = [own]
    for side in ("ahead", "behind"):
        # The link behind a vehicle is the link ahead of its follower.
        link = np.arange(n) if side == "ahead" else (np.arange(n) + 1) % n
        when = estimate[f"{side}_measured_ns"][:cycles] // run.scenario.period_ns
        for name, of, read, variance in (
            ("gap", gap, radar["gap"], (share * gap) ** 2),
            ("speed", front - speed, radar["relative_speed"], (share * front) ** 2),
        ):
            found.append(
                Quantity(
                    name=f"{'relative ' if name == 'speed' else ''}{name} {side}",
                    unit="m" if name == "gap" else "m/s",
                    true=of[:, link],
                    measured=read[:cycles, link],
                    estimated=_at_its_cycle(estimate[f"{side}_{name}"][:cycles], when),
                    std=_at_its_cycle(estimate[f"{side}_{name}_std"][:cycles], when),
                    reading_variance=variance[:, link],
                    filters_reading=by_radar,
                )
            )
    return tuple(found)


def first_disturbed(run: Run) -> int:
    """Return the vehicle that first brakes or follows a trace, or else the one in the middle.

    It has a vehicle ahead: on the open road vehicle 2 replaces vehicle 1.
    """
    first = first_disturbance(run.events)
    vehicle = first.vehicle if first is not None else (run.vehicles + 1) // 2
    return max(vehicle, 2) if run.scenario.ring_length_m is None else vehicle


def _at_its_cycle(values: NDArray[Any], when: NDArray[np.int64]) -> Floats:
    """Move estimates (cycles, vehicles) to the rows `when` that they are for; < 0 means never.

    An estimate that is the same as in the row before is left out.
    """
    fresh = when >= 0
    fresh[1:] &= when[1:] != when[:-1]
    row, column = np.nonzero(fresh)
    placed = np.full(values.shape, np.nan)
    placed[when[row, column], column] = values[row, column]
    return placed
