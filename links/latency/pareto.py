"""A Pareto distribution (type I) with scale min_ms, cut off at max_ms."""

from __future__ import annotations

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
    low, high = bounds_ms(values)
    mean = values.mean_ms or 0.0
    index = mean / (mean - low)
    within = 1.0 if high is None else 1.0 - (low / high) ** index
    return lambda draws: whole_ns(low * (1.0 - portion(draws, within)) ** (-1.0 / index))


LATENCY = Distribution(
    name="pareto",
    quantile=quantile,
    needs=("min_ms", "mean_ms"),
    may=("max_ms",),
    above_min=True,
    positive="min_ms",
    meaning="scale min_ms, mean_ms",
    place=6,
)
