"""Tracks the vehicle ahead by radar, with Singer's model of its acceleration.

Singer (1970), "Estimating optimal tracking filter performance for manned maneuvering targets": the
acceleration is noise of a given standard deviation, which passes a first-order lag with the time
constant of a manoeuvre. The filter has fixed gains, those of the Kalman filter in its steady state.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final, NamedTuple

from zenvoy.laws.matrices import IDENTITY, Matrix, Vector, inverse, product, total, transposed
from zenvoy.laws.relative import Number, Relative

_DOUBLINGS: Final = 40  # whatever the model, the last ones change nothing


class Singer(NamedTuple):
    """The model.

    manoeuvre_s: time constant of a manoeuvre, s. acceleration_std_mps2: standard deviation of the
    acceleration, m/s². gap_std_m, speed_std_mps: those of the errors of the radar, m and m/s.
    """

    manoeuvre_s: float
    acceleration_std_mps2: float
    gap_std_m: float
    speed_std_mps: float


class Track(NamedTuple):
    """The state: gap (m), relative speed (m/s), and acceleration of the vehicle ahead (m/s²)."""

    p: Number
    v: Number
    a: Number


class Gains(NamedTuple):
    """Changes of the state per error: first of the gap, then of the relative speed."""

    gap: Vector
    speed: Vector


def predicted(track: Track, own_acceleration: Number, model: Singer, period_s: float) -> Track:
    """Return the track a period later, in which the host had a mean acceleration (m/s²)."""
    to_gap, to_speed, decay = _acceleration_column(model, period_s)
    lost = own_acceleration * period_s
    return Track(
        track.p + period_s * track.v + to_gap * track.a - 0.5 * period_s * lost,
        track.v + to_speed * track.a - lost,
        decay * track.a,
    )


def corrected(track: Track, read: Relative, gains: Gains) -> Track:
    """Return the track after a reading of the radar."""
    for at, (reading, gain) in enumerate(zip(read, gains, strict=True)):
        error = reading - track[at]
        track = Track._make(one + k * error for one, k in zip(track, gain, strict=True))
    return track


@lru_cache(maxsize=64)
def steady_gains(model: Singer, period_s: float) -> Gains:
    """Return the gains of the Kalman filter in its steady state, with a reading in each period.

    It uses neither BLAS nor `sum`, so that the bits depend on neither processor nor Python.
    """
    covariance = _steady_covariance(model, period_s)
    gap, after = _update(covariance, 0, model.gap_std_m)
    speed, _ = _update(after, 1, model.speed_std_mps)
    return Gains(gap, speed)


def _steady_covariance(model: Singer, period_s: float) -> Matrix:
    """Return the covariance before a reading, by doubling: each step covers twice the periods.

    Chu, Fan, Lin and Wang (2004), "Structure-preserving algorithms for periodic discrete-time
    algebraic Riccati equations".
    """
    to_gap, to_speed, decay = _acceleration_column(model, period_s)
    a = ((1.0, 0.0, 0.0), (period_s, 1.0, 0.0), (to_gap, to_speed, decay))
    of_gap, of_speed = 1.0 / model.gap_std_m**2, 1.0 / model.speed_std_mps**2
    g = ((of_gap, 0.0, 0.0), (0.0, of_speed, 0.0), (0.0, 0.0, 0.0))
    h = _noise(model, period_s)
    for _ in range(_DOUBLINGS):
        w = inverse(total(IDENTITY, product(g, h)))
        aw = product(a, w)
        added = product(product(transposed(a), h), product(w, a))
        g = total(g, product(product(aw, g), transposed(a)))
        h, a = total(h, added), product(aw, a)
    return h


def _acceleration_column(model: Singer, period_s: float) -> Vector:
    """Return what an acceleration of 1 m/s² adds to the gap, the speed, and itself in a period.

    It decays by the bilinear approximation of an exponential, whose last bit would depend on the
    processor, and in between on a straight line.
    """
    ratio = period_s / model.manoeuvre_s
    decay = max(0.0, (2.0 - ratio) / (2.0 + ratio))
    return period_s * period_s * (2.0 + decay) / 6.0, period_s * (1.0 + decay) / 2.0, decay


def _noise(model: Singer, period_s: float) -> Matrix:
    """Return the covariance that white noise in da/dt, of density 2 σ² / τ, adds in a period."""
    t = period_s
    q = 2.0 * model.acceleration_std_mps2 * model.acceleration_std_mps2 / model.manoeuvre_s * t
    return (
        (q * t * t * t * t / 20.0, q * t * t * t / 8.0, q * t * t / 6.0),
        (q * t * t * t / 8.0, q * t * t / 3.0, q * t / 2.0),
        (q * t * t / 6.0, q * t / 2.0, q),
    )


def _update(covariance: Matrix, which: int, std: float) -> tuple[Vector, Matrix]:
    """Return the gains for a reading of one entry of the state, and the covariance after it."""
    row = covariance[which]
    variance = row[which] + std * std
    x, y, z = row[0] / variance, row[1] / variance, row[2] / variance
    first, second, third = covariance
    return (x, y, z), (_less(first, x, row), _less(second, y, row), _less(third, z, row))


def _less(line: Vector, gain: float, row: Vector) -> Vector:
    return line[0] - gain * row[0], line[1] - gain * row[1], line[2] - gain * row[2]
