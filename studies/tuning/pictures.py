"""Pictures of a search: its objective over the trials, and over each parameter."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.page.section import Picture
from zenvoy.analysis.page.style import (
    CYCLE,
    THEORY,
    figure_legend,
    plain,
    plain_log,
    subplots,
    whole_numbers,
)
from zenvoy.studies.sweeps.results import unit_of_axis
from zenvoy.studies.sweeps.table import shown, titled
from zenvoy.studies.tuning.figures import FIGURES
from zenvoy.studies.tuning.parameters import Choices, Parameter, Span
from zenvoy.studies.tuning.study import TuneStudy
from zenvoy.studies.tuning.trial import Trial, best_of
from zenvoy.values.wording import capitalized

_PANELS: Final = 3  # in a row
_FEASIBLE: Final = CYCLE[0]
_INFEASIBLE: Final = CYCLE[1]
_BEST: Final = CYCLE[2]
_FAILED: Final = CYCLE[3]
_BAND: Final = 0.08  # of the height, below the points
_MARGIN: Final = 0.06  # of the height, above and below what is shown

Floats = NDArray[np.float64]


class _Kinds(NamedTuple):
    """The trials by outcome; those ruled out and those that failed have no value."""

    feasible: list[Trial]
    infeasible: list[Trial]
    ruled_out: list[Trial]
    failed: list[Trial]


def pictures(study: TuneStudy, trials: Sequence[Trial]) -> list[Picture]:
    """Return the pictures of a search; none if no trial has an objective."""
    kinds = _kinds(study, trials)
    if not kinds.feasible and not kinds.infeasible:
        return []
    what = FIGURES[study.figure].meaning
    crosses = " Crosses do not hold the constraints." if kinds.infeasible else ""
    ticks = " The marks at the lower edge are trials without a value." * bool(
        kinds.ruled_out or kinds.failed
    )
    over = "one seed" if len(study.seeds) == 1 else f"{len(study.seeds)} seeds"
    return [
        Picture(
            name="search",
            caption=f"{capitalized(what)} over the trials, means over {over}. The line is the best"
            f" feasible value so far.{crosses}{ticks}",
            draw=partial(_draw_search, study, trials),
        ),
        Picture(
            name="parameters",
            caption=f"{capitalized(what)} over each parameter, a point for each trial. The ring is"
            f" the best one.{crosses}{ticks}",
            draw=partial(_draw_parameters, study, trials),
        ),
    ]


def _kinds(study: TuneStudy, trials: Sequence[Trial]) -> _Kinds:
    found = _Kinds([], [], [], [])
    for trial in trials:
        if trial.failure is not None:
            found.failed.append(trial)
        elif trial.objective(study) is None:
            found.ruled_out.append(trial)
        elif trial.feasible(study):
            found.feasible.append(trial)
        else:
            found.infeasible.append(trial)
    return found


def _objectives(study: TuneStudy, trials: Sequence[Trial]) -> Floats:
    return np.array([trial.objective(study) for trial in trials], dtype=np.float64)


def _draw_search(study: TuneStudy, trials: Sequence[Trial]) -> Figure:
    figure, axes = subplots(height_in=3.2)
    kinds = _kinds(study, trials)
    _points(axes, study, kinds, lambda trial: trial.number)
    best = np.minimum if study.direction == "minimize" else np.maximum
    if kinds.feasible:
        at = [trial.number for trial in kinds.feasible]
        so_far = best.accumulate(_objectives(study, kinds.feasible))
        axes.step(
            [*at, trials[-1].number],
            [*so_far, so_far[-1]],
            where="post",
            color=_BEST,
            zorder=2.5,
            label="best so far",
        )
    axes.set_xlim(0, len(trials) + 1)
    whole_numbers(axes.xaxis)
    axes.set_xlabel("trial")
    axes.set_ylabel(_title(study))
    figure_legend(figure, axes)
    return figure


def _points(axes: Any, study: TuneStudy, kinds: _Kinds, place: Any) -> None:
    """Draw a point for each trial, at the position that `place` returns."""
    styles = {
        "feasible": (kinds.feasible, "o", _FEASIBLE),
        "infeasible": (kinds.infeasible, "x", _INFEASIBLE),
    }
    for label, (some, marker, colour) in styles.items():
        if some:
            at = [place(trial) for trial in some]
            axes.plot(
                at, _objectives(study, some), marker, color=colour, ms=4, zorder=3, label=label
            )
    _limit(axes, study, kinds)
    for label, some, marker, colour in (
        ("ruled out", kinds.ruled_out, "|", THEORY),
        ("failed", kinds.failed, "v", _FAILED),
    ):
        if some:
            axes.plot(
                [place(trial) for trial in some],
                np.full(len(some), 0.4 * _BAND),
                marker,
                color=colour,
                ms=6 if marker == "|" else 4,
                label=label,
                transform=axes.get_xaxis_transform(),
            )


def _limit(axes: Any, study: TuneStudy, kinds: _Kinds) -> None:
    """Leave room around the points, and a band below them for the marks."""
    values = _objectives(study, [*kinds.feasible, *kinds.infeasible])
    low, high = float(values.min()), float(values.max())
    room = _MARGIN * (high - low) or 0.1 * abs(high) or 1.0
    band = _BAND * (high - low + 2.0 * room) if kinds.ruled_out or kinds.failed else 0.0
    axes.set_ylim(low - room - band, high + room)


def _draw_parameters(study: TuneStudy, trials: Sequence[Trial]) -> Figure:
    across = 2 if len(study.parameters) == 4 else min(_PANELS, len(study.parameters))
    down = -(-len(study.parameters) // across)
    figure, axes = subplots(down, across, height_in=0.4 + 2.8 * down, squeeze=False, sharey=True)
    kinds, best = _kinds(study, trials), best_of(study, trials)
    for axis, (key, parameter) in zip(axes.flat, study.parameters.items(), strict=False):
        _scale(axis, parameter)
        _points(axis, study, kinds, lambda trial, k=key, p=parameter: _place(p, trial.point[k]))
        if best is not None:
            at, value = _place(parameter, best.point[key]), best.objective(study)
            axis.plot([at], [value], "o", ms=10, mfc="none", mec=_BEST, mew=1.5, label="best")
        axis.set_xlabel(plain(titled(key, unit_of_axis(key))))
    for axis in list(axes.flat)[len(study.parameters) :]:
        axis.remove()
    for row in axes[:, 0]:
        row.set_ylabel(_title(study))
    figure_legend(figure, *axes.flat[: len(study.parameters)])
    return figure


def _scale(axis: Any, parameter: Parameter) -> None:
    if isinstance(parameter, Choices):
        labels = [plain(str(shown(choice))) for choice in parameter.choices]
        axis.set_xticks(range(len(labels)), labels)
        axis.set_xlim(-0.5, len(labels) - 0.5)
        return
    assert isinstance(parameter, Span)
    low, high = float(parameter.low), float(parameter.high)
    if parameter.log:
        room = (high / low) ** 0.04
        axis.set_xscale("log")
        axis.set_xlim(low / room, high * room)
        plain_log(axis.xaxis)
    else:
        room = 0.04 * (high - low)
        axis.set_xlim(low - room, high + room)


def _place(parameter: Parameter, value: Any) -> float:
    if isinstance(parameter, Choices):
        return float(parameter.labels.index(parameter.proposed_as(value)))
    return float(value)


def _title(study: TuneStudy) -> str:
    measure = FIGURES[study.figure]
    return plain(titled(measure.meaning, measure.unit))
