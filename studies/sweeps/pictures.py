"""Pictures of a sweep: a measure over one axis as lines, over two as a heat map."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.statistics import Mean
from zenvoy.analysis.page.section import Picture
from zenvoy.analysis.page.style import CYCLE, SPEED_MAP, figure_legend, plain, subplots
from zenvoy.studies.sweeps.plan import PlannedCell
from zenvoy.studies.sweeps.results import Results, unit_of_axis
from zenvoy.studies.sweeps.table import half, shown, titled
from zenvoy.values.wording import capitalized

_MOST_LINES: Final = len(CYCLE)
_MOST_NUMBERS: Final = 64  # cells of a heat map that are also written as numbers
_MOST_TICKS: Final = 10
_MOST_ROWS: Final = 16  # ticks on a vertical axis, where texts do not run into each other
_PANELS: Final = 3  # in a row

Floats = NDArray[np.float64]


def pictures(results: Results) -> list[Picture]:
    """Return a picture of each measure that a cell has.

    A measure that the study does not name has one only if it differs between runs.
    """
    axes = results.plan.study.axes
    drawn = []
    for measure in results.measures:
        means = results.means(measure)
        if not means or not (results.plan.study.measures or results.differs(measure)):
            continue
        if any(axis.random for axis in axes.values()):
            draw, what = _scattered(results, measure, means)
        elif len(axes) == 2:
            draw, what = _mapped(results, measure, means)
        else:
            draw, what = _lined(results, measure, means)
        seeds = len(results.plan.seeds)
        over = "one seed" if seeds == 1 else f"{seeds} seeds"
        caption = (
            f"{capitalized(MEASURES[measure].meaning)}: {what} {capitalized(over)} for each cell."
        )
        drawn.append(Picture(name=measure, caption=caption, draw=draw))
    return drawn


def _title(name: str, unit: str) -> str:
    return plain(titled(name, unit))


def _title_of_measure(measure: str) -> str:
    return _title(MEASURES[measure].meaning, MEASURES[measure].unit)


def _title_of_axis(key: str) -> str:
    return _title(key, unit_of_axis(key))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _unique(values: Sequence[Any]) -> list[Any]:
    found: list[Any] = []
    for value in values:
        if value not in found:
            found.append(value)
    return found


# One axis, or more than two: lines over the first.


def _lined(results: Results, measure: str, means: dict[int, Mean]) -> tuple[Any, str]:
    first, *rest = results.plan.study.axes
    lines: dict[str, list[PlannedCell]] = {}
    for cell in results.plan.cells:
        label = ", ".join(f"{key.rpartition('.')[2]} {shown(cell.point[key])}" for key in rest)
        lines.setdefault(label, []).append(cell)
    labels = list(lines)
    if len(labels) > _MOST_LINES:  # evenly, with both ends
        picked = np.linspace(0, len(labels) - 1, _MOST_LINES).round().astype(int)
        chosen = {labels[number]: lines[labels[number]] for number in picked}
    else:
        chosen = lines
    what = f"means over the seeds by {first}, with their 95 % intervals."
    if rest:
        count = f"{len(chosen)} of {len(lines)} combinations" if chosen != lines else "combination"
        each = "A line is drawn for each" if chosen == lines else "Lines are drawn for"
        what += f" {each} {count} of {' and '.join(rest)}."
    return partial(_draw_lines, first, chosen, measure, means), what


def _draw_lines(
    first: str, lines: dict[str, list[PlannedCell]], measure: str, means: dict[int, Mean]
) -> Figure:
    figure, axis = subplots(height_in=3.2)
    values = _unique([cell.point[first] for cells in lines.values() for cell in cells])
    numeric = all(map(_is_number, values))
    for number, (label, cells) in enumerate(lines.items()):
        known = [cell for cell in cells if cell.number in means]
        at = [cell.point[first] if numeric else values.index(cell.point[first]) for cell in known]
        of_cells = [means[cell.number] for cell in known]
        axis.errorbar(
            at,
            [mean.mean for mean in of_cells],
            [half(mean) or 0.0 for mean in of_cells],
            fmt="o-",
            ms=3.5,
            capsize=2,
            color=CYCLE[number],
            label=plain(label),
        )
    if not numeric:
        axis.set_xticks(range(len(values)), [plain(str(shown(value))) for value in values])
    axis.set_xlabel(_title_of_axis(first))
    axis.set_ylabel(_title_of_measure(measure))
    if len(lines) > 1:
        figure_legend(figure, axis, ncols=min(3, len(lines)))
    return figure


# Two axes: a heat map of the means, and one of the intervals.


def _mapped(results: Results, measure: str, means: dict[int, Mean]) -> tuple[Any, str]:
    across, up = results.plan.study.axes
    what = f"means over the seeds by {across} and {up}"
    if len(results.plan.seeds) > 1:
        what += ", and half the width of their 95 % intervals"
    return partial(_draw_map, results, measure, means), f"{what}. White cells have no value."


def _draw_map(results: Results, measure: str, means: dict[int, Mean]) -> Figure:
    across, up = results.plan.study.axes
    columns = _unique([cell.point[across] for cell in results.plan.cells])
    rows = _unique([cell.point[up] for cell in results.plan.cells])
    mean = np.full((len(rows), len(columns)), np.nan)
    spread = mean.copy()
    for cell in results.plan.cells:
        if (found := means.get(cell.number)) is not None:
            place = rows.index(cell.point[up]), columns.index(cell.point[across])
            mean[place] = found.mean
            spread[place] = np.nan if found.n < 2 else half(found)
    maps = {_title_of_measure(measure): mean}
    if not np.isnan(spread).all():
        maps[f"± 95 %, {MEASURES[measure].unit}".removesuffix(", ")] = spread
    figure, axes = subplots(1, len(maps), height_in=3.4, squeeze=False, sharey=True)
    for axis, (title, values) in zip(axes[0], maps.items(), strict=True):
        _draw_cells(figure, axis, title, values)
        _ticks(axis.xaxis, columns)
        axis.set_xlabel(_title_of_axis(across))
    _ticks(axes[0, 0].yaxis, rows, _MOST_ROWS)
    axes[0, 0].set_ylabel(_title_of_axis(up))
    return figure


def _draw_cells(figure: Figure, axis: Any, title: str, values: Floats) -> None:
    image = axis.pcolormesh(values, cmap=SPEED_MAP, rasterized=values.size > _MOST_NUMBERS)
    axis.grid(visible=False)
    axis.set_title(title, loc="left")
    figure.colorbar(image, ax=axis)
    if values.size > _MOST_NUMBERS:
        return
    low, high = np.nanmin(values), np.nanmax(values)
    for (row, column), value in np.ndenumerate(values):
        if not np.isnan(value):
            bright = value > low + 0.6 * (high - low)
            axis.text(
                column + 0.5,
                row + 0.5,
                f"{value:.3g}",
                ha="center",
                va="center",
                fontsize=7,
                color="black" if bright else "white",
            )


def _ticks(axis: Any, values: list[Any], most: int = _MOST_TICKS) -> None:
    step = -(-len(values) // most)
    numbers = range(0, len(values), step)
    labels = [plain(_short(values[number])) for number in numbers]
    axis.set_ticks([number + 0.5 for number in numbers], labels)


def _short(value: Any) -> str:
    found = shown(value)
    return f"{found:.4g}" if isinstance(found, float) else str(found)


# Random axes: a panel for each axis, with a point for each cell.


def _scattered(results: Results, measure: str, means: dict[int, Mean]) -> tuple[Any, str]:
    keys = list(results.plan.study.axes)
    what = "means over the seeds with their 95 % intervals, a point for each cell"
    what += f", by {' and by '.join(keys)}."
    return partial(_draw_scatter, results, keys, measure, means), what


def _draw_scatter(
    results: Results, keys: list[str], measure: str, means: dict[int, Mean]
) -> Figure:
    across = min(_PANELS, len(keys))
    down = -(-len(keys) // across)
    figure, axes = subplots(down, across, height_in=2.8 * down, squeeze=False, sharey=True)
    cells = [cell for cell in results.plan.cells if cell.number in means]
    for axis, key in zip(axes.flat, keys, strict=False):
        values = _unique([cell.point[key] for cell in results.plan.cells])
        numeric = all(map(_is_number, values))
        axis.errorbar(
            [c.point[key] if numeric else values.index(c.point[key]) for c in cells],
            [means[cell.number].mean for cell in cells],
            [half(means[cell.number]) or 0.0 for cell in cells],
            fmt="o",
            ms=3.0,
            lw=0.8,
            color=CYCLE[0],
        )
        if not numeric:
            axis.set_xticks(range(len(values)), [plain(_short(value)) for value in values])
        axis.set_xlabel(_title_of_axis(key))
    for axis in list(axes.flat)[len(keys) :]:
        axis.remove()
    for row in axes[:, 0]:
        row.set_ylabel(_title_of_measure(measure))
    return figure
