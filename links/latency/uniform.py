"""A uniform distribution between two latencies."""

from __future__ import annotations

from zenvoy.links.distribution import Delays, Distribution, Span, Values, uniform_delays


def quantile(values: Values, _technology_ms: Span) -> Delays:
    """Return the quantile function."""
    return uniform_delays(values.min_ms or 0.0, values.max_ms or 0.0)


LATENCY = Distribution(
    name="uniform",
    quantile=quantile,
    needs=("min_ms", "max_ms"),
    meaning="min_ms to max_ms",
    place=3,
)
