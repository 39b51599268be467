"""A normal distribution, truncated to [min_ms, max_ms]."""

from __future__ import annotations

from statistics import NormalDist

from zenvoy.keyed_random.quantile import normal_quantile
from zenvoy.links.distribution import (
    Delays,
    Distribution,
    Span,
    Values,
    bounds_ms,
    portion,
    whole_ns,
)


def quantile(values: Values, _technology_ms: Span) -> Delays:
    """Return the quantile function."""
    mean, std = values.mean_ms or 0.0, values.std_ms or 0.0
    low, high = bounds_ms(values)
    distribution = NormalDist(mean, std)
    below = distribution.cdf(low)
    within = (1.0 if high is None else distribution.cdf(high)) - below
    return lambda draws: whole_ns(mean + std * normal_quantile(portion(draws, within, below)))


LATENCY = Distribution(
    name="normal",
    quantile=quantile,
    needs=("mean_ms", "std_ms"),
    may=("min_ms", "max_ms"),
    meaning="mean_ms and std_ms, cut off at min_ms (null: 0) and max_ms",
    place=4,
)
