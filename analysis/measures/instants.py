"""Chooses the instants at which a run is examined: the paper's in its own cases, else others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.spans import disturbances, first_disturbance

PAPER_S: Final = (9.0, 30.0, 100.0, 300.0)
PAPER_SPREAD_S: Final = 100.0  # at which the paper gives the spread of the speeds
_AFTER_S: Final = (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)
_MAX_INSTANTS: Final = 6
_SETTLING_S: Final = 30.0


def of_paper(run: Run) -> bool:
    """Return whether a run is one of the paper's cases, to which the paper's instants apply."""
    return run.name.startswith("paper/")


def row_at(time_s: NDArray[np.float64], at_s: float) -> int:
    """Return the first row at or after an instant; len(time_s) where there is none.

    Times come from nanoseconds, so an instant counts as reached a nanosecond early.
    """
    return int(np.searchsorted(time_s, at_s - 1e-9))


def instants(run: Run) -> list[tuple[float, int]]:
    """Return the instants (s) of a run that has motion, each with its row."""
    wanted = list(PAPER_S) if of_paper(run) else instants_s([run])
    return [(at_s, row_at(run.time_s, at_s)) for at_s in wanted if at_s <= run.time_s[-1]]


def instants_s(runs: Sequence[Run]) -> list[float]:
    """Return up to six instants that all runs have, at growing intervals, s.

    They begin with the first disturbance of any run, or with the start where there is none.
    """
    last_s = min(float(run.time_s[-1]) for run in runs)
    disturbed_s = [what.start_s for run in runs for what in disturbances(run.events)]
    start_s = min([*(at_s for at_s in disturbed_s if at_s < last_s), last_s])
    start_s = 0.0 if start_s == last_s else start_s
    return [start_s + after_s for after_s in _AFTER_S if start_s + after_s <= last_s][
        -_MAX_INSTANTS:
    ]


def around_first(run: Run, before_s: float, least_s: float) -> tuple[float, float]:
    """Return a span of time within the run around its first disturbance, s.

    It begins `before_s` before the disturbance. It lasts for `least_s`, or until half a minute
    after the disturbance if that is later. Without a disturbance it begins with the run.
    """
    first = first_disturbance(run.events)
    last_s = float(run.time_s[-1])
    if first is None:
        return 0.0, min(least_s, last_s)
    start_s = max(0.0, first.start_s - before_s)
    return start_s, min(max(start_s + least_s, first.end_s + _SETTLING_S), last_s)
