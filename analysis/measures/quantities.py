"""What vehicles measure and estimate, beside the truth of the same instant."""

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
    """One quantity of every vehicle; arrays (cycles, vehicles), NaN where there is nothing.

    Row k is the start of cycle k in all of them: an estimate stands at the instant that it is of,
    which for a link is that of its newest reading, and appears there once. `std` is the filter's
    standard deviation, `reading_variance` that of `measured` around the truth, as the sensors are.
    """

    name: str
    unit: str
    true: Floats
    measured: Floats
    estimated: Floats
    std: Floats
    reading_variance: Floats
    filters_reading: bool
    """Whether the filter is fed with `measured`; not where it compares positions instead."""

    @property
    def label(self) -> str:
        """Name and unit, as on an axis."""
        return f"{self.name}, {self.unit}"

    @property
    def error(self) -> Floats:
        """Of the estimate, in `unit`."""
        return self.estimated - self.true


def quantities(run: Run) -> tuple[Quantity, ...]:
    """Own speed, then gap and relative speed of the link ahead, then those of the link behind.

    Empty where no cycle was logged. The reading of the link behind is the radar's of the vehicle
    behind, as it tells it (paper Section III).
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
        # The link behind a vehicle is the one ahead of its follower.
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
    """Vehicle that is the first to brake or follow a trace, or else the one in the middle.

    Not one without a vehicle ahead: instead of vehicle 1 of the open road, the one behind it.
    """
    first = first_disturbance(run.events)
    vehicle = first.vehicle if first is not None else (run.vehicles + 1) // 2
    return max(vehicle, 2) if run.scenario.ring_length_m is None else vehicle


def _at_its_cycle(values: NDArray[Any], when: NDArray[np.int64]) -> Floats:
    """Estimates (cycles, vehicles) in the rows that they are of: `when`, < 0 for never.

    An estimate that is still the one of the row before is left out.
    """
    fresh = when >= 0
    fresh[1:] &= when[1:] != when[:-1]
    row, column = np.nonzero(fresh)
    placed = np.full(values.shape, np.nan)
    placed[when[row, column], column] = values[row, column]
    return placed
