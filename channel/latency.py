"""How long frames are on their way: a distribution of latency, as its quantile function.

One uniform draw per frame gives its latency, whatever the distribution: a frame that is early under
one is early under all.
"""

from __future__ import annotations

from collections.abc import Callable
from statistics import NormalDist
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc, gammaincinv

from zenvoy.bus.keyed_random.quantile import normal_quantile
from zenvoy.channel.rows import Rows
from zenvoy.channel.sender_offset import SenderOffsets
from zenvoy.scenarios import Latency

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

Delays = Callable[[Floats], Ints]
"""From draws in [0, 1) to latencies, ns, of the same shape."""

_NS_PER_MS: Final = 1e6
_BELOW_ONE: Final = 1.0 - 2.0**-53
_TAIL: Final = 0.01


class LatencyModel:
    """All that a section of latency asks for; sections of other `number` draw for themselves.

    `technology_ms`: bounds of Table I's delay.
    """

    def __init__(
        self,
        latency: Latency,
        technology_ms: tuple[float, float],
        seed: int,
        size: int,
        number: int = 0,
    ) -> None:
        self._delays = delays(latency, technology_ms)
        self._offsets = SenderOffsets(latency.sender_offset, seed, size, number)
        self.least_ns = int(self._delays(np.zeros(1))[0])  # quantile functions never fall
        self.ordered = not latency.reorder
        self.draws = latency.distribution != "fixed" and (
            latency.distribution != "technology" or technology_ms[0] < technology_ms[1]
        )

    def of(self, rows: Rows, share: Floats) -> Ints:
        """Latencies, ns, (r,); `share`: a draw in [0, 1) for each."""
        return self._delays(share) + self._offsets.of(rows)


def delays(latency: Latency, technology_ms: tuple[float, float]) -> Delays:
    """The quantile function of a scenario's latency; `technology_ms`: bounds of Table I's delay.

    Times on the air and offsets of senders are not in it.
    """
    quantile = _QUANTILES[latency.distribution]
    if latency.distribution == "technology":
        low_ms, high_ms = technology_ms
        latency = Latency(distribution="uniform", min_ms=low_ms, max_ms=high_ms)
    return quantile(latency)


def _fixed(latency: Latency) -> Delays:
    delay_ns = round((latency.mean_ms or 0.0) * _NS_PER_MS)
    return lambda draws: np.full(draws.shape, delay_ns)


def _uniform(latency: Latency) -> Delays:
    low_ns, high_ns = (round((bound or 0.0) * _NS_PER_MS) for bound in _bounds(latency))
    return lambda draws: low_ns + np.floor(draws * (high_ns - low_ns)).astype(np.int64)


def _normal(latency: Latency) -> Delays:
    """Truncated to [min_ms, max_ms]."""
    mean, std = latency.mean_ms or 0.0, latency.std_ms or 0.0
    low, high = _bounds(latency)
    distribution = NormalDist(mean, std)
    below = distribution.cdf(low)
    within = (1.0 if high is None else distribution.cdf(high)) - below
    return lambda draws: _ns(mean + std * normal_quantile(_portion(draws, within, below)))


def _gamma(latency: Latency) -> Delays:
    """min_ms and a gamma distribution above it, cut off at max_ms."""
    low, high = _bounds(latency)
    mean, std = (latency.mean_ms or 0.0) - low, latency.std_ms or 0.0
    shape, scale = (mean / std) ** 2, std**2 / mean
    within = 1.0 if high is None else float(gammainc(shape, (high - low) / scale))
    quantile = _gamma_quantile(shape)
    return lambda draws: _ns(low + scale * quantile(_portion(draws, within)))


def _gamma_quantile(shape: float) -> Callable[[Floats], Floats]:
    """That of a gamma distribution of scale 1: straight lines between 8,192 points, tails exact.

    Half a microsecond each would be half the cost of a cycle. In the portion between the tails the
    lines are off by less than a ten-thousandth of the standard deviation.
    """
    portions = np.linspace(_TAIL, 1.0 - _TAIL, 8_192)
    points = gammaincinv(shape, portions)

    def quantile(portion: Floats) -> Floats:
        value: Floats = np.interp(portion, portions, points)
        tail = (portion < _TAIL) | (portion > 1.0 - _TAIL)
        value[tail] = gammaincinv(shape, portion[tail])
        return value

    return quantile


def _pareto(latency: Latency) -> Delays:
    """Pareto's first kind, of scale min_ms, cut off at max_ms."""
    low, high = _bounds(latency)
    mean = latency.mean_ms or 0.0
    index = mean / (mean - low)
    within = 1.0 if high is None else 1.0 - (low / high) ** index
    return lambda draws: _ns(low * (1.0 - _portion(draws, within)) ** (-1.0 / index))


def _samples(latency: Latency) -> Delays:
    """Any of the samples, each as likely."""
    samples_ns = np.sort(_ns(np.array(latency.samples_ms)))
    return lambda draws: samples_ns[np.floor(draws * len(samples_ns)).astype(np.int64)]


_QUANTILES: Final[dict[str, Callable[[Latency], Delays]]] = {
    "technology": _uniform,
    "fixed": _fixed,
    "uniform": _uniform,
    "normal": _normal,
    "gamma": _gamma,
    "pareto": _pareto,
    "samples": _samples,
}


def _bounds(latency: Latency) -> tuple[float, float | None]:
    return latency.min_ms or 0.0, latency.max_ms


def _portion(draws: Floats, within: float, below: float = 0.0) -> Floats:
    """Draws from [0, 1) moved to the portion of the probability that is not cut off."""
    return np.minimum(below + within * draws, _BELOW_ONE)


def _ns(latency_ms: Floats) -> Ints:
    """Whole ns: what is left of the last bits, in which processors may differ, is nothing."""
    return np.floor(latency_ms * _NS_PER_MS).astype(np.int64)
