"""Measured latencies, all equally likely."""

from __future__ import annotations

import numpy as np

from zenvoy.links.distribution import Delays, Distribution, Span, Values, whole_ns


def quantile(values: Values, _technology_ms: Span) -> Delays:
    """Return the quantile function."""
    samples_ns = np.sort(whole_ns(np.array(values.samples_ms)))
    return lambda draws: samples_ns[np.floor(draws * len(samples_ns)).astype(np.int64)]


LATENCY = Distribution(
    name="samples",
    quantile=quantile,
    needs=("samples_ms",),
    least_ms=lambda values, _: min(values.samples_ms),
    meaning="any of samples_ms",
    place=7,
)
