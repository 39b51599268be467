"""Figures of merit of the fleet's motion. Axis 0 is time, axis 1 is the vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Limits

Floats = NDArray[np.float64]

_PER_HOUR: Final = 3600.0
_ROUNDING: Final = 1e-9  # relative


class Band(NamedTuple):
    """Means and standard deviations, each (T,)."""

    mean: Floats
    std: Floats


def over_runs(series: Floats) -> Band:
    """Return mean and standard deviation (n - 1) over runs; `series` has a row per run, (runs, T).

    The standard deviation of a single run is NaN.
    """
    if len(series) == 1:
        return Band(series[0], np.full(series.shape[1], np.nan))
    return Band(series.mean(axis=0), series.std(axis=0, ddof=1))


def over_windows(time_s: Floats, values: Floats, width_s: float) -> tuple[Floats, Band]:
    """Return the middles of windows (W,), s, and mean and standard deviation in each.

    `values` are (T, k), such as the three smallest gaps. The standard deviation then covers both
    the differences between the three and their motion within the window. A last window that is
    less than half full is left out.
    """
    start_s = time_s[0]
    number = np.floor((time_s - start_s) / width_s + 1e-9).astype(np.int64)
    windows = int(np.floor((time_s[-1] - start_s) / width_s + 0.5)) or 1
    inside = [values[number == w] for w in range(windows)]
    middles = start_s + width_s * (np.arange(windows) + 0.5)
    mean = np.array([v.mean() for v in inside])
    return middles, Band(mean, np.array([v.std() for v in inside]))


def speed_spread(speed: Floats) -> Floats:
    """Return the standard deviation of the vehicles' speeds at each time (T,), m/s."""
    return np.asarray(speed.std(axis=1))


def at_limits(
    acceleration: Floats, limits: Sequence[Limits], share: float = 1.0 - _ROUNDING
) -> NDArray[np.bool_]:
    """Return when each vehicle is at a share of one of its limits or beyond (T, n).

    acceleration (T, n) in m/s²; limits: those of each vehicle.
    """
    lowest, highest = share * np.array(limits).T
    return np.asarray((acceleration <= lowest) | (acceleration >= highest))


def rms(values: Floats) -> float:
    """Return the root mean square over all times and vehicles."""
    return float(np.sqrt(np.mean(values * values)))


def jerk(acceleration: Floats, period_s: float) -> Floats:
    """Return the change of acceleration from one period to the next (T - 1, n), m/s³."""
    return np.diff(acceleration, axis=0) / period_s


def flow_by_density(position: Floats, speed: Floats, ring_length_m: float | None) -> Floats:
    """Return vehicles per hour at each time (T,): vehicles per metre times their mean speed.

    The density is n over the length of the ring, or n - 1 over the fleet's extent on the open road.
    """
    if ring_length_m is None:
        density = (position.shape[1] - 1) / (position[:, 0] - position[:, -1])
    else:
        density = np.full(len(position), position.shape[1] / ring_length_m)
    return np.asarray(density * speed.mean(axis=1) * _PER_HOUR)


def crossings(
    time_s: Floats, position: Floats, point_m: float, ring_length_m: float | None
) -> Floats:
    """Return the times at which vehicles pass a point of the road, in ascending order, s.

    Speed counts as constant between two rows. On the ring every lap counts.
    """
    travelled = position - point_m
    if ring_length_m:
        laps = np.floor(travelled / ring_length_m)
    else:
        laps = (travelled >= 0.0).astype(np.float64)
    passed = np.maximum(np.diff(laps, axis=0), 0.0).astype(np.int64)
    rows, vehicles = np.nonzero(passed)
    times = passed[rows, vehicles]
    lap = 1 + np.arange(times.sum()) - np.repeat(np.cumsum(times) - times, times)
    rows, vehicles = np.repeat(rows, times), np.repeat(vehicles, times)
    line = (laps[rows, vehicles] + lap) * ring_length_m if ring_length_m else 0.0
    before, after = travelled[rows, vehicles], travelled[rows + 1, vehicles]
    part = (line - before) / (after - before)
    return np.sort(time_s[rows] + part * (time_s[rows + 1] - time_s[rows]))


def counted_flow(times_s: Floats, duration_s: float | None) -> float | None:
    """Return vehicles per hour from the times at which they passed.

    They are counted over `duration_s`. If that is None, they are counted from the first to the last
    vehicle, because an open road is empty before and after the fleet. The result is None for too
    few vehicles.
    """
    if duration_s is not None:
        return len(times_s) / duration_s * _PER_HOUR
    if len(times_s) < 2 or times_s[-1] <= times_s[0]:
        return None
    return float((len(times_s) - 1) / (times_s[-1] - times_s[0]) * _PER_HOUR)
