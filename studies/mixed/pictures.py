"""The pictures of mixed traffic."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.statistics import Mean, mean_and_half
from zenvoy.analysis.page.section import Picture
from zenvoy.analysis.page.speed_map import speed_map
from zenvoy.analysis.page.style import MODEL_COLOURS, SPEED_MAP, THEORY, figure_legend, subplots
from zenvoy.studies.mixed.penetration import LAWS, SCENARIOS, Line, Point
from zenvoy.studies.mixed.ring import NOBODY, Driven
from zenvoy.studies.sweeps.table import half

Floats = NDArray[np.float64]

_EVERY: Final = 10  # cycles; a picture needs no more
_COLOURS: Final = {**MODEL_COLOURS, NOBODY: MODEL_COLOURS["IDM"]}


def speeds(runs: Mapping[str, Run], control_s: float) -> Picture:
    """Return the picture of all speeds in one run of each variant."""
    caption = (
        "Speeds of the 22 cars over time, in a run without control, and in others with the same "
        f"seed in which car 1 is controlled from {control_s:g} s on. Dark stripes that climb are "
        "waves: they run from car to car against the traffic."
    )
    return Picture(name="ring-speeds", caption=caption, draw=partial(_speeds, runs, control_s))


def _speeds(runs: Mapping[str, Run], control_s: float) -> Figure:
    figure, axes = subplots(len(runs), height_in=1.7 * len(runs), sharex=True, squeeze=False)
    highest = max(float(run.truth["speed"].max()) for run in runs.values())
    scale = Normalize(0.0, highest)
    for row, (car, run) in zip(axes[:, 0], runs.items(), strict=True):
        speed_map(row, run.time_s[::_EVERY], run.truth["speed"][::_EVERY], scale)
        row.set_ylabel("car")
        row.set_title(car, loc="left")
        if car != NOBODY:
            row.axvline(control_s, color="white", lw=1.0, ls="--")
    axes[-1, 0].set_xlabel("time, s")
    colours = ScalarMappable(scale, SPEED_MAP)
    figure.colorbar(colours, ax=list(axes[:, 0]), label="speed, m/s")
    return figure


def spread(runs: Sequence[Driven], control_s: float) -> Picture:
    """Return the picture of the spread of speed over time, with intervals over seeds."""
    caption = (
        "Standard deviation of speed over the 22 cars: mean over seeds, and its 95 % interval. "
        f"One car is controlled from {control_s:g} s on."
    )
    return Picture(name="ring-spread", caption=caption, draw=partial(_spread, runs, control_s))


def _spread(runs: Sequence[Driven], control_s: float) -> Figure:
    figure, axes = subplots(height_in=3.0)
    for one in runs:
        time_s = one.series[0]["time_s"][::_EVERY]
        values = np.array([series["speed_spread_mps"][::_EVERY] for series in one.series])
        mean, interval = mean_and_half(values)
        colour = _COLOURS[one.car]
        axes.plot(time_s, mean, color=colour, label=one.car)
        if len(values) > 1:
            low = np.maximum(mean - interval, 0.0)
            axes.fill_between(time_s, low, mean + interval, color=colour, alpha=0.2, lw=0)
    axes.axvline(control_s, color=THEORY, lw=0.8, ls="--")
    axes.set_xlabel("time, s")
    axes.set_ylabel("standard deviation of speed, m/s")
    axes.set_ylim(bottom=0.0)
    figure_legend(figure, axes)
    return figure


class _Panel(NamedTuple):
    title: str
    of: Callable[[Point], Mean | None]
    from_zero: bool = True


_PANELS: Final = (
    _Panel("growth of waves, 1/s\n(linear theory)", lambda point: point.growth_per_s, False),
    _Panel("standard deviation\nof speed, m/s", lambda point: point.std_mps),
    _Panel("throughput, 1/h", lambda point: point.flow_per_h),
    _Panel("collisions per run", lambda point: point.collisions),
)


def penetration(points: Mapping[Line, Sequence[Point]]) -> Picture:
    """Return the picture of traffic against the share of equipped cars."""
    caption = (
        "Traffic at the end of the runs, and collisions in the whole runs, against the share of "
        "equipped cars among drivers under IDM. Top: the fastest wave by linear theory without "
        "delay; it grows above 0, and decays below. Solid lines with circles: the drivers send "
        "beacons, too. Dashed lines with crosses: they send none, so an equipped car with a driver "
        "behind falls back to FM. Means over seeds; bars: 95 % intervals."
    )
    return Picture(name="penetration", caption=caption, draw=partial(_penetration, points))


def _penetration(points: Mapping[Line, Sequence[Point]]) -> Figure:
    scenarios = [name for name in SCENARIOS if any(line.scenario == name for line in points)]
    figure, axes = subplots(len(_PANELS), len(scenarios), height_in=7.6, sharex=True, squeeze=False)
    for column, name in enumerate(scenarios):
        axes[0, column].set_title(SCENARIOS[name], loc="left")
        axes[-1, column].set_xlabel("equipped cars, %")
        for row, panel in enumerate(_PANELS):
            for law in LAWS:
                for beacons in (True, False):
                    line = Line(name, law, beacons)
                    if line in points:
                        _line(axes[row, column], line, points[line], panel)
            if panel.from_zero:
                axes[row, column].set_ylim(bottom=0.0)
            else:
                axes[row, column].axhline(0.0, color=THEORY, lw=0.8)
    for row, panel in enumerate(_PANELS):
        axes[row, 0].set_ylabel(panel.title)
    figure_legend(figure, axes[1, 0], ncols=3)
    return figure


def _line(axes: Any, line: Line, points: Sequence[Point], panel: _Panel) -> None:
    found = [(100.0 * point.share, mean) for point in points if (mean := panel.of(point))]
    if not found:
        return
    axes.errorbar(
        [share for share, _ in found],
        [mean.mean for _, mean in found],
        [half(mean) or 0.0 for _, mean in found],
        fmt="o-" if line.beacons else "x--",
        ms=3.5,
        lw=1.0,
        capsize=2,
        color=MODEL_COLOURS[line.law],
        label=f"{line.law}{'' if line.beacons else ', humans silent'}",
    )
