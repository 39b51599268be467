"""The instants at which a run is looked at: the paper's in its own cases, else from the run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.spans import disturbances, first_disturbance

PAPER_S: Final = (9.0, 30.0, 100.0, 300.0)
PAPER_SPREAD_S: Final = 100.0  # at which the paper tells how far the speeds are apart
_AFTER_S: Final = (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)
_MOST: Final = 6
_SETTLES_S: Final = 30.0


def of_paper(run: Run) -> bool:
    """Whether a run is one of the paper's cases, whose instants mean something for it."""
    return run.name.startswith("paper/")


def row_at(time_s: NDArray[np.float64], at_s: float) -> int:
    """Return the first row at an instant or after it; len(time_s) where there is none.

    Times come from nanoseconds, so an instant counts as reached a nanosecond early.
    """
    return int(np.searchsorted(time_s, at_s - 1e-9))


def instants(run: Run) -> list[tuple[float, int]]:
    """Instants of a run that has motion, s, and the row of each."""
    wanted = list(PAPER_S) if of_paper(run) else instants_s([run])
    return [(at_s, row_at(run.time_s, at_s)) for at_s in wanted if at_s <= run.time_s[-1]]


def instants_s(runs: Sequence[Run]) -> list[float]:
    """Up to six instants that all runs have, farther and farther apart, s.

    They count from the first disturbance of any run, or from the start where there is none.
    """
    last_s = min(float(run.time_s[-1]) for run in runs)
    disturbed_s = [what.start_s for run in runs for what in disturbances(run.events)]
    start_s = min([*(at_s for at_s in disturbed_s if at_s < last_s), last_s])
    start_s = 0.0 if start_s == last_s else start_s
    return [start_s + after_s for after_s in _AFTER_S if start_s + after_s <= last_s][-_MOST:]


def around_first(run: Run, before_s: float, least_s: float) -> tuple[float, float]:
    """A span of time from `before_s` before the first disturbance on, s, within the run.

    It lasts for `least_s` or until half a minute after that disturbance, whichever is longer; from
    the start of the run where there is none.
    """
    first = first_disturbance(run.events)
    last_s = float(run.time_s[-1])
    if first is None:
        return 0.0, min(least_s, last_s)
    start_s = max(0.0, first.start_s - before_s)
    return start_s, min(max(start_s + least_s, first.end_s + _SETTLES_S), last_s)
