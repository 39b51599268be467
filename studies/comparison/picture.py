"""The picture of a comparison: a panel for each measure, with a row for each law."""

from __future__ import annotations

from functools import partial
from textwrap import fill
from typing import Any, Final

from matplotlib.figure import Figure

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.page.section import Picture
from zenvoy.analysis.page.style import THEORY, plain, subplots
from zenvoy.studies.comparison.compared import Comparison, Finding
from zenvoy.studies.sweeps.plan import counted
from zenvoy.studies.sweeps.table import half, titled
from zenvoy.values.wording import capitalized

_ACROSS: Final = 2  # panels in a row
_TITLE_WIDTH: Final = 44  # characters
_LAW_IN: Final = 0.24  # height of a law's row
_FRAME_IN: Final = 0.75  # height of a panel's title and axis
_EVEN: Final = {"speed_swing_ratio": 1.0}
"""The value that separates good from bad, for measures that have one."""


def picture(compared: Comparison) -> Picture | None:
    """Return the picture of the measures that are named or differ; None if there are none."""
    named = compared.results.plan.study.measures or ()
    shown = [name for name in compared.measures if compared.results.differs(name)]
    shown = shown or [name for name in compared.measures if name in named]
    if not shown:
        return None
    seeds = counted(len(compared.results.plan.seeds), "seed")
    caption = f"Laws in the same scenario with the same {seeds}: means, and their 95 % intervals."
    same = [name for name in compared.measures if name not in shown]
    if same:
        what = " and ".join(MEASURES[name].meaning for name in same)
        verb = "is" if len(same) == 1 else "are"
        caption += f" {capitalized(what)} {verb} the same in all runs, and not shown."
    return Picture(name="laws", caption=caption, draw=partial(_drawn, compared, shown))


def _drawn(compared: Comparison, measures: list[str]) -> Figure:
    across = min(_ACROSS, len(measures))
    down = -(-len(measures) // across)
    height_in = down * (_FRAME_IN + _LAW_IN * len(compared.laws))
    figure, grid = subplots(down, across, height_in=height_in, squeeze=False, sharey=True)
    for axes, measure in zip(grid.flat, measures, strict=False):
        _panel(axes, compared.of(measure), measure)
    grid[0, 0].set_yticks(range(len(compared.laws)), [plain(law.label) for law in compared.laws])
    grid[0, 0].set_ylim(len(compared.laws) - 0.5, -0.5)  # the first law on top
    for axes in list(grid.flat)[len(measures) :]:
        axes.remove()
    return figure


def _panel(axes: Any, findings: tuple[Finding, ...], measure: str) -> None:
    title = titled(MEASURES[measure].meaning, MEASURES[measure].unit)
    axes.set_title(fill(plain(capitalized(title)), _TITLE_WIDTH), loc="left")
    if measure in _EVEN:
        axes.axvline(_EVEN[measure], color=THEORY, lw=0.9, ls="--")
    for row, one in enumerate(findings):
        if one.mean is not None:
            axes.errorbar(
                one.mean.mean,
                row,
                xerr=half(one.mean) or 0.0,
                fmt="o",
                ms=4.5,
                capsize=3,
                color=one.law.colour,
            )
    axes.grid(visible=False, axis="y")
