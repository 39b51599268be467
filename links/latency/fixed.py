"""The same latency for every frame."""

from __future__ import annotations

from zenvoy.links.distribution import Delays, Distribution, Span, Values, constant_delays


def quantile(values: Values, _technology_ms: Span) -> Delays:
    """Return the quantile function."""
    return constant_delays(values.mean_ms or 0.0)


LATENCY = Distribution(
    name="fixed",
    quantile=quantile,
    needs=("mean_ms",),
    least_ms=lambda values, _: values.mean_ms or 0.0,
    constant=lambda _: True,
    meaning="mean_ms",
    place=2,
)
