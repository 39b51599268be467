"""Measures how a disturbance travels through a string: gains, waves and modes.

Axis 0 is time, axis 1 is the vehicle. Deviations are speeds minus the speed before the disturbance,
m/s.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_EARLIER_S: Final = 2.0  # a dip may come this much before the dip of the previous vehicle
_MIN_R2: Final = 0.5  # of the line through arrivals; below it there is no wave
_MAX_SKIPPED: Final = 2  # vehicles in a row without a dip; after more, another wave may be found
_ROUNDING_MPS: Final = 1e-9
_MIN_SAMPLES: Final = 90  # of a mode's amplitude, for its fit; there may be twice as many
_NOISE_FACTOR: Final = 3.0  # an amplitude of more than this many RMS of the noise is not noise
_MAX_NOISE: Final = math.exp(-1.0)  # of the largest amplitude; more than this is not just noise
_MAX_PENCIL: Final = 40  # a third of the samples is best, but large matrices occupy all cores
_MIN_WEIGHT: Final = 0.1  # of the largest exponential; smaller ones are not part of a fit


class Norms(NamedTuple):
    """L2 norm (root of the integrated square) and L∞ norm (largest magnitude), each (n,)."""

    l2: Floats
    linf: Floats


def norms(deviation: Floats, period_s: float) -> Norms:
    """Return the norms over time of deviations (T, n)."""
    return Norms(
        l2=np.sqrt((deviation * deviation).sum(axis=0) * period_s),
        linf=np.abs(deviation).max(axis=0),
    )


class Arrivals(NamedTuple):
    """Times (s) at which a dip reaches vehicles, by their distance from the disturbed one."""

    steps: NDArray[np.int64]
    """How many vehicles away from the disturbed one each is."""
    time_s: Floats


def arrivals(
    time_s: Floats, deviation: Floats, order: NDArray[np.int64], least: float, reach_s: float
) -> Arrivals:
    """Follow a dip in speed from vehicle to vehicle, as long as it is deeper than `least` (m/s).

    `order` lists the columns of `deviation` (T, n) as the wave reaches them, beginning with the
    disturbed vehicle. The dip of each vehicle is sought until `reach_s` after the dip of the
    previous one. The search begins a little before that dip: a vehicle that learns of a braking by
    V2V may react before its neighbour. A vehicle whose speed has no minimum there is left out, and
    after more than two in a row the wave is lost. The time of the dip is the vertex of the parabola
    through the three lowest rows.
    """
    steps: list[int] = []
    found: list[float] = []
    for k, column in enumerate(order):
        since, at_s = (k - steps[-1], found[-1]) if found else (1, float(time_s[0]))
        if since > _MAX_SKIPPED + 1:
            break
        low, high = _span(time_s, at_s, since * reach_s)
        values = deviation[low:high, column]
        row = int(np.argmax(values <= values.min() + _ROUNDING_MPS))
        if -values[row] < least:
            break
        if found and row in {0, len(values) - 1}:
            continue
        steps.append(k)
        found.append(_vertex(time_s, deviation[:, column], low + row))
    return Arrivals(np.array(steps, dtype=np.int64), np.array(found))


def _span(time_s: Floats, at_s: float, reach_s: float) -> tuple[int, int]:
    """Return the rows from a little before an instant until `reach_s` after it."""
    low, high = at_s - _EARLIER_S, at_s + reach_s
    return int(np.searchsorted(time_s, low)), int(np.searchsorted(time_s, high, side="right"))


def _vertex(time_s: Floats, values: Floats, row: int) -> float:
    """Return the time of the lowest value near a row; of the row where a plateau begins there."""
    if row in {0, len(values) - 1} or values[row + 1] - values[row] <= _ROUNDING_MPS:
        return float(time_s[row])
    before, at, after = values[row - 1 : row + 2]
    bend = before - 2.0 * at + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(time_s[row] + shift * (time_s[row + 1] - time_s[row]))


def wave_speed(found: Arrivals) -> float | None:
    """Return the speed of a wave in vehicles per second, from a line through the arrivals.

    The disturbed vehicle is left out, because its dip was imposed on it. The result is None for
    fewer than three other vehicles, and if a line fits the arrivals badly: then they are noise.
    """
    if len(found.steps) < 4 or np.ptp(found.time_s[1:]) <= 0.0:
        return None
    slope = np.polyfit(found.steps[1:], found.time_s[1:], 1)[0]
    correlation = np.corrcoef(found.steps[1:], found.time_s[1:])[0, 1]
    return float(1.0 / slope) if slope > 0.0 and correlation**2 >= _MIN_R2 else None


class Response(NamedTuple):
    """Ratio of two spectra (F,) at frequencies ω (F,), rad/s."""

    omega: Floats
    ratio: Complexes


def response(head: Floats, tail: Floats, period_s: float, least: float) -> Response:
    """Return the transfer function from one acceleration (T,) to another, where it is excited.

    It is the ratio of their Fourier transforms. For motions that begin and end with constant speed
    this is also the ratio for their speeds, even if the speed does not return to its old value. A
    frequency is included if the amplitude of `head`, in acceleration or in speed, is at least the
    share `least` of its maximum. Oscillations shorter than eight periods of the command are not
    included, because there the hold of the commands matters.
    """
    spectrum, after = np.fft.rfft(head), np.fft.rfft(tail)
    omega = 2.0 * np.pi * np.fft.rfftfreq(len(head), period_s)
    slow = (omega > 0.0) & (omega <= 0.25 * np.pi / period_s)
    shown = np.zeros(len(omega), dtype=np.bool_)
    for size in (np.abs(spectrum), np.abs(spectrum) / np.where(omega > 0.0, omega, np.inf)):
        shown |= slow & (size >= least * size.max())
    return Response(np.asarray(omega[shown]), np.asarray(after[shown] / spectrum[shown]))


def mode_amplitude(position: Floats, ring_length_m: float, number: int) -> Complexes:
    """Return the amplitude (T,), m, of mode `number` in a ring's deviations from even spacing."""
    n = position.shape[1]
    vehicle = np.arange(n)
    deviation = position + vehicle * (ring_length_m / n)
    return np.asarray(deviation @ np.exp(-2j * np.pi * number * vehicle / n) / n)


class Decay(NamedTuple):
    """Growth rate (1/s) and frequency (rad/s) of an amplitude, and the R² of the fit."""

    rate: float
    omega: float
    r2: float


def decay(amplitude: Complexes, period_s: float, exponents: int = 2) -> Decay | None:
    """Fit A e^(s₁t) + B e^(s₂t) + … to an amplitude (T,), and return the slowest exponent.

    A mode of a ring has two exponents, or three if actuators have a lag. They interfere, so
    |amplitude| oscillates, and a line through its logarithm would mislead. The matrix pencil (Hua
    and Sarkar 1990) finds them without an initial guess. The result is None for fewer than 8 rows,
    and where nothing moves.
    """
    block = max(1, len(amplitude) // _MIN_SAMPLES)
    rows = len(amplitude) // block
    # The mean of an exponential over blocks is the same exponential times a constant.
    values = amplitude[: rows * block].reshape(rows, block).mean(axis=1)
    if rows < 8 or not np.abs(values).max() > 0.0:
        return None
    step_s = block * period_s
    poles = _poles(values, exponents)
    powers = poles[None, :] ** np.arange(rows)[:, None]
    weights = np.linalg.lstsq(powers, values, rcond=None)[0]
    residual = np.abs(values - powers @ weights)
    r2 = 1.0 - float((residual**2).sum() / (np.abs(values) ** 2).sum())
    size = np.abs(weights) * np.abs(powers).max(axis=0)
    found = np.log(poles[size >= _MIN_WEIGHT * size.max()]) / step_s
    slow = found[np.argmax(found.real)]
    return Decay(float(slow.real), float(abs(slow.imag)), r2)


def _poles(values: Complexes, count: int) -> Complexes:
    """Return the `count` z for which values[k] is a weighted sum of z^k."""
    columns = min(len(values) // 3, _MAX_PENCIL)
    hankel = np.lib.stride_tricks.sliding_window_view(values, columns)
    _, _, rows = np.linalg.svd(hankel, full_matrices=False)
    basis = rows[:count].T  # rows of the Hankel matrix are sums of (z^0, z^1, ...)
    return np.asarray(np.linalg.eigvals(np.linalg.pinv(basis[:-1]) @ basis[1:]))


def lasting(amplitude: Complexes, least: float) -> int:
    """Return the number of rows until the amplitude stays below a level.

    The level is the share `least` of the largest amplitude, or three times the RMS of the last
    fifth of the rows if that is higher. The latter is ignored where it is too large to be noise.
    """
    size = np.abs(amplitude)
    largest = float(size.max(initial=0.0))
    noise = _NOISE_FACTOR * float(np.sqrt(np.mean(size[-max(1, len(size) // 5) :] ** 2)))
    level = max(least * largest, noise if noise < _MAX_NOISE * largest else 0.0)
    above = np.flatnonzero(size > level)
    return int(above[-1]) + 1 if above.size else 0
