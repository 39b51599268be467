"""What a disturbance becomes on its way through a string: gains, waves, modes, from the motion.

Axis 0 is time, axis 1 the vehicle. Deviations are from the speed (m/s) before the disturbance.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_EARLIER_S: Final = 2.0  # by how much a dip may come before that of the vehicle ahead
_IN_LINE: Final = 0.5  # R² of a line through arrivals from which its slope is a speed
_MOST_SKIPPED: Final = 2  # vehicles without a dip: beyond, another wave would be found
_SAME: Final = 1e-9  # m/s: rounding
_SAMPLES: Final = 90  # of a mode's amplitude, for its fit, and up to twice as many
_NOISES: Final = 3.0  # root mean squares: more is no noise
_LITTLE: Final = math.exp(-1.0)  # of the largest amplitude: above it there is a decay to fit
_PENCIL: Final = 40  # a third of the samples is best; larger ones set all cores to work
_COUNTS: Final = 0.1  # exponentials of less than this share of the largest are no part of a fit


class Norms(NamedTuple):
    """L2 norm (root of the integral of the square) and L∞ norm (largest magnitude), each (n,)."""

    l2: Floats
    linf: Floats


def norms(deviation: Floats, period_s: float) -> Norms:
    """Norms over time of deviations (T, n)."""
    return Norms(
        l2=np.sqrt((deviation * deviation).sum(axis=0) * period_s),
        linf=np.abs(deviation).max(axis=0),
    )


class Arrivals(NamedTuple):
    """Vehicles by how far behind the disturbed one they are, and when (s) the dip was there."""

    behind: NDArray[np.int64]
    time_s: Floats


def arrivals(
    time_s: Floats, deviation: Floats, order: NDArray[np.int64], least: float, reach_s: float
) -> Arrivals:
    """Follow a dip of speed from vehicle to vehicle, as long as it is deeper than `least` (m/s).

    `order`: columns of `deviation` (T, n) as the wave meets them, the disturbed vehicle first. At
    each vehicle the dip is looked for from a little before that of the one before, since who hears
    of a braking by V2V may be slowest first, until `reach_s` after it. A vehicle whose speed has
    no minimum there is left out, and after two of them the wave is lost. The instant is that of
    the parabola through the three lowest rows.
    """
    behind: list[int] = []
    found: list[float] = []
    for k, column in enumerate(order):
        since, at_s = (k - behind[-1], found[-1]) if found else (1, float(time_s[0]))
        if since > _MOST_SKIPPED + 1:
            break
        low, high = _span(time_s, at_s, since * reach_s)
        values = deviation[low:high, column]
        row = int(np.argmax(values <= values.min() + _SAME))
        if -values[row] < least:
            break
        if found and row in {0, len(values) - 1}:
            continue
        behind.append(k)
        found.append(_vertex(time_s, deviation[:, column], low + row))
    return Arrivals(np.array(behind, dtype=np.int64), np.array(found))


def _span(time_s: Floats, at_s: float, reach_s: float) -> tuple[int, int]:
    """Rows from a little before an instant until `reach_s` after it."""
    low, high = at_s - _EARLIER_S, at_s + reach_s
    return int(np.searchsorted(time_s, low)), int(np.searchsorted(time_s, high, side="right"))


def _vertex(time_s: Floats, values: Floats, row: int) -> float:
    """Instant of the lowest value near a row: of the row itself where a plateau begins there."""
    if row in {0, len(values) - 1} or values[row + 1] - values[row] <= _SAME:
        return float(time_s[row])
    before, at, after = values[row - 1 : row + 2]
    bend = before - 2.0 * at + after
    shift = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(time_s[row] + shift * (time_s[row + 1] - time_s[row]))


def wave_speed(found: Arrivals) -> float | None:
    """Vehicles per second, by a line through the arrivals.

    The disturbed vehicle itself is left out: its dip is what was done to it. None for fewer than
    three others, and where a line describes them badly: then there is no wave, but noise.
    """
    if len(found.behind) < 4 or np.ptp(found.time_s[1:]) <= 0.0:
        return None
    slope = np.polyfit(found.behind[1:], found.time_s[1:], 1)[0]
    correlation = np.corrcoef(found.behind[1:], found.time_s[1:])[0, 1]
    return float(1.0 / slope) if slope > 0.0 and correlation**2 >= _IN_LINE else None


class Response(NamedTuple):
    """Ratio of two spectra (F,) at frequencies ω (F,), rad/s."""

    omega: Floats
    ratio: Complexes


def response(head: Floats, tail: Floats, period_s: float, least: float) -> Response:
    """Transfer function from one acceleration (T,) to another, where the first has something.

    Ratio of their Fourier transforms, which for motions that begin and end at rest is that of
    their speeds, also where the speed does not come back. Only frequencies at which the head has
    at least the share `least` of its largest amplitude, of acceleration or of speed, are told, and
    none of fewer than eight periods a swing: there it matters how commands are held.
    """
    spectrum, after = np.fft.rfft(head), np.fft.rfft(tail)
    omega = 2.0 * np.pi * np.fft.rfftfreq(len(head), period_s)
    slow = (omega > 0.0) & (omega <= 0.25 * np.pi / period_s)
    shown = np.zeros(len(omega), dtype=np.bool_)
    for size in (np.abs(spectrum), np.abs(spectrum) / np.where(omega > 0.0, omega, np.inf)):
        shown |= slow & (size >= least * size.max())
    return Response(np.asarray(omega[shown]), np.asarray(after[shown] / spectrum[shown]))


def mode_amplitude(position: Floats, ring_length_m: float, number: int) -> Complexes:
    """Amplitude (T,), m, of mode `number` of a ring: of the deviations from even spacing."""
    n = position.shape[1]
    vehicle = np.arange(n)
    deviation = position + vehicle * (ring_length_m / n)
    return np.asarray(deviation @ np.exp(-2j * np.pi * number * vehicle / n) / n)


class Decay(NamedTuple):
    """Growth rate (1/s) and frequency (rad/s) of an amplitude; r2: how well that describes it."""

    rate: float
    omega: float
    r2: float


def decay(amplitude: Complexes, period_s: float) -> Decay | None:
    """Fit A e^(s₁t) + B e^(s₂t) to an amplitude (T,); the slower of the two counts.

    A mode of a ring has two exponents: |amplitude| alone swings as they interfere, so a line
    through its logarithm would mislead. They are found by the matrix pencil (Hua and Sarkar
    1990), which needs no guess. None for fewer than 8 rows, and where nothing moves.
    """
    block = max(1, len(amplitude) // _SAMPLES)
    rows = len(amplitude) // block
    # The mean over a block of an exponential is that exponential, times a constant.
    values = amplitude[: rows * block].reshape(rows, block).mean(axis=1)
    if rows < 8 or not np.abs(values).max() > 0.0:
        return None
    step_s = block * period_s
    poles = _poles(values)
    powers = poles[None, :] ** np.arange(rows)[:, None]
    weights = np.linalg.lstsq(powers, values, rcond=None)[0]
    residual = np.abs(values - powers @ weights)
    r2 = 1.0 - float((residual**2).sum() / (np.abs(values) ** 2).sum())
    size = np.abs(weights) * np.abs(powers).max(axis=0)
    exponents = np.log(poles[size >= _COUNTS * size.max()]) / step_s
    slow = exponents[np.argmax(exponents.real)]
    return Decay(float(slow.real), float(abs(slow.imag)), r2)


def _poles(values: Complexes) -> Complexes:
    """The two z for which values[k] is a sum of z^k."""
    columns = min(len(values) // 3, _PENCIL)
    hankel = np.lib.stride_tricks.sliding_window_view(values, columns)
    _, _, rows = np.linalg.svd(hankel, full_matrices=False)
    basis = rows[:2].T  # rows of the Hankel matrix are sums of (z^0, z^1, ...)
    return np.asarray(np.linalg.eigvals(np.linalg.pinv(basis[:-1]) @ basis[1:]))


def lasting(amplitude: Complexes, least: float) -> int:
    """Rows until the amplitude has fallen for good below the share `least` of its largest.

    Or to thrice what it is in the last fifth of the rows, where that is little enough to be what
    remains of it: noise.
    """
    size = np.abs(amplitude)
    largest = float(size.max(initial=0.0))
    rest = _NOISES * float(np.sqrt(np.mean(size[-max(1, len(size) // 5) :] ** 2)))
    level = max(least * largest, rest if rest < _LITTLE * largest else 0.0)
    above = np.flatnonzero(size > level)
    return int(above[-1]) + 1 if above.size else 0
