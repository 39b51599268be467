"""The record of a distribution of latency: the values that it needs, and its quantile function.

One uniform draw per frame gives its latency under any distribution: a frame that is early under one
is early under all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

Delays = Callable[[Floats], Ints]
"""Maps draws in [0, 1) to latencies, ns, of the same shape. It never decreases."""

Span = tuple[float, float]

_NS_PER_MS: Final = 1e6
_BELOW_ONE: Final = 1.0 - 2.0**-53


class Values(Protocol):
    """The keys of `channel.latency` that distributions share, ms; None or empty if not given."""

    @property
    def mean_ms(self) -> float | None:
        """The mean, before truncation."""

    @property
    def std_ms(self) -> float | None:
        """The standard deviation, before truncation."""

    @property
    def min_ms(self) -> float | None:
        """The shortest latency."""

    @property
    def max_ms(self) -> float | None:
        """The longest latency."""

    @property
    def samples_ms(self) -> tuple[float, ...]:
        """Measured latencies."""


def _min_ms(values: Values, _technology_ms: Span) -> float:
    return values.min_ms or 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """A distribution of latency, which a scenario names in `channel.latency.distribution`.

    quantile: returns Delays, from the values and the technology's delay (from, to; ms). needs, may:
    the required keys, and the optional ones. least_ms: its shortest latency. above_min: whether the
    mean must be greater than min_ms. positive: a key that may not be 0. constant: whether all
    frames have the same latency, so that nothing is drawn. meaning: a few words for the schema.
    place: its place in the list of names; records without one come last, by name.
    """

    name: str
    quantile: Callable[[Values, Span], Delays]
    needs: tuple[str, ...] = ()
    may: tuple[str, ...] = ()
    least_ms: Callable[[Values, Span], float] = _min_ms
    above_min: bool = False
    positive: str | None = None
    constant: Callable[[Span], bool] = lambda _technology_ms: False
    meaning: str = ""
    place: int | None = None


def bounds_ms(values: Values) -> tuple[float, float | None]:
    """Return min_ms (0 if it is not given) and max_ms."""
    return values.min_ms or 0.0, values.max_ms


def portion(draws: Floats, within: float, below: float = 0.0) -> Floats:
    """Return draws from [0, 1), mapped to the part of the probability that is not cut off."""
    return np.minimum(below + within * draws, _BELOW_ONE)


def whole_ns(latency_ms: Floats) -> Ints:
    """Return whole ns, without the last bits, in which processors may differ."""
    return np.floor(latency_ms * _NS_PER_MS).astype(np.int64)


def uniform_delays(low_ms: float, high_ms: float) -> Delays:
    """Return the quantile function of a uniform distribution from `low_ms` to `high_ms`."""
    low_ns, high_ns = round(low_ms * _NS_PER_MS), round(high_ms * _NS_PER_MS)
    return lambda draws: low_ns + np.floor(draws * (high_ns - low_ns)).astype(np.int64)


def constant_delays(delay_ms: float) -> Delays:
    """Return the quantile function of a constant latency."""
    delay_ns = round(delay_ms * _NS_PER_MS)
    return lambda draws: np.full(draws.shape, delay_ns)


def greatest_ns(delays: Delays) -> int | None:
    """Return the greatest latency that can be drawn, ns; None if it does not fit into 64 bits."""
    with np.errstate(invalid="ignore"):
        greatest = int(delays(np.array([_BELOW_ONE]))[0])
    return greatest if greatest >= 0 else None
