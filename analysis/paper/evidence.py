"""The evidence for the paper's evaluation: digests by case and seed, and means over seeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.measures.instants import row_at
from zenvoy.analysis.measures.statistics import Mean, mean_of

Floats = NDArray[np.float64]

MODELS: Final = ("FM", "BCM", "MBCM", "PBCM")


class Pair(NamedTuple):
    """Measurement error (a fraction) and total delay (s)."""

    error: float
    delay_s: float

    @property
    def title(self) -> str:
        """Text for figures and tables."""
        return f"error {self.error * 100:g} %, delay {self.delay_s:g} s"


PAIRS: Final = tuple(Pair(*both) for both in product((0.03, 0.10), (0.1, 0.2)))


def case(model: str, pair: Pair) -> str:
    """Return the number of the paper's case, as in the name of its scenario: "07"."""
    return f"{4 * MODELS.index(model) + PAIRS.index(pair) + 1:02}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """Runs by label ("07" for the paper's cases), each in order of seed."""

    runs: Mapping[str, tuple[Digest, ...]]

    def __getitem__(self, label: str) -> tuple[Digest, ...]:
        return self.runs[label]

    def over(self, label: str, figure: Callable[[Digest], float]) -> Mean:
        """Return the mean of a figure over the seeds of `label`."""
        return mean_of([figure(run) for run in self.runs[label]])

    def series(self, label: str, name: str) -> Floats:
        """Return a column of the digests, (seeds, T)."""
        return np.stack([getattr(run, name) for run in self.runs[label]])


def settled(run: Digest, name: str, from_s: float, to_s: float) -> float:
    """Return the mean of a digest's column over a span of time; NaN where the run has no rows."""
    within = (run.time_s > from_s - 1e-9) & (run.time_s < to_s + 1e-9)
    values = getattr(run, name)[within]
    return float(values.mean()) if values.size else float("nan")


def lowest(run: Digest, name: str, from_s: float, to_s: float) -> float:
    """Return the smallest value over a span of time; NaN where the run has no rows."""
    within = (run.time_s > from_s - 1e-9) & (run.time_s < to_s + 1e-9)
    values = getattr(run, name)[within]
    return float(values.min()) if values.size else float("nan")


def at(run: Digest, name: str, time_s: float) -> float:
    """Return the value at an instant; NaN where the run had ended."""
    row = row_at(run.time_s, time_s)
    return float(getattr(run, name)[row]) if row < len(run.time_s) else float("nan")


def agreed(run: Digest, what: str, name: str, span: str = "whole") -> float:
    """Return how well `what` ("measured_speed") agrees with the truth; NaN where it is missing."""
    fit = run.facts["fit"][span][what]
    return float("nan") if fit is None else float(fit[name])


def recovery_s(run: Digest, brake_s: float = 10.0, span_s: float = 5.0) -> float:
    """Return how long after the braking MinDistance recovers for good, s; NaN where it never does.

    It has recovered when its mean over the last `span_s` is at most 0.5 m below the mean over the
    `span_s` before the braking, and stays there.
    """
    width = max(1, round(span_s / float(run.time_s[1] - run.time_s[0])))
    smooth = np.convolve(run.min_distance, np.full(width, 1.0 / width), mode="valid")
    ends_s = run.time_s[width - 1 :]
    before = settled(run, "min_distance", brake_s - span_s, brake_s)
    below = np.flatnonzero((smooth < before - 0.5) & (ends_s > brake_s))
    if below.size == 0:
        return 0.0
    if below[-1] == len(smooth) - 1:
        return float("nan")
    return float(ends_s[below[-1] + 1] - brake_s)
