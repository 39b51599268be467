"""The delay of the technology: uniform between its bounds (paper Table I)."""

from __future__ import annotations

from zenvoy.links.distribution import Delays, Distribution, Span, Values, uniform_delays


def quantile(_values: Values, technology_ms: Span) -> Delays:
    """Return the quantile function."""
    return uniform_delays(*technology_ms)


LATENCY = Distribution(
    name="technology",
    quantile=quantile,
    least_ms=lambda _, technology_ms: technology_ms[0],
    constant=lambda technology_ms: technology_ms[0] == technology_ms[1],
    meaning="as in Table I",
    place=1,
)
