"""The chapter "Recorded convoy": the vehicles of a run next to the cars that were recorded."""

from __future__ import annotations

from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.growth import growths
from zenvoy.analysis.measures.motion import rms
from zenvoy.analysis.page import style
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet
from zenvoy.links.distance import gaps
from zenvoy.scenarios.convoys.convoy import Convoy

Floats = NDArray[np.float64]


class _Both(NamedTuple):
    """Time (T,), and speeds (T, n) and gaps (T, n) of the cars and of the vehicles of a run.

    Gaps are from bumper to bumper; those of the first are NaN.
    """

    time_s: Floats
    car_speed: Floats
    car_gap: Floats
    speed: Floats
    gap: Floats


def recorded_section(run: Run, convoy: Convoy) -> Section:
    """Return tables and pictures of a run and the recorded cars, as long as both last.

    Raises ValueError if there are not as many cars as vehicles, or no common time.
    """
    both = _both(run, convoy)
    return Section(
        title="Recorded convoy",
        notes=(f"Vehicles are compared with the cars in {convoy.name}, from 0 s to "
               f"{both.time_s[-1]:g} s.",),
        sheets=(_sheet(both, convoy),),
        pictures=(
            Picture(
                name="recorded-speeds",
                caption="Speeds of the recorded cars and of the vehicles of the run. Black: the "
                "leader; bright: the last one.",
                draw=lambda: _speeds(both),
            ),
            Picture(
                name="recorded-swing",
                caption="Swing of the speed, its standard deviation over time, by place in the "
                "convoy: of the recorded cars, and of the vehicles of the run.",
                draw=lambda: _swing(both),
            ),
        ),
    )  # fmt: skip


def _both(run: Run, convoy: Convoy) -> _Both:
    """Return cars and vehicles at the starts of the cycles that both have."""
    size, cars = run.scenario.fleet.size, len(convoy.cars)
    if size != cars:
        raise ValueError(f"{cars} cars, but the run has {size} vehicles")
    rows = run.time_s <= convoy.time_s[-1] + 1e-6
    if rows.sum() < 2:
        raise ValueError("the run has no time in common with it")
    time_s = run.time_s[rows]

    def at(values: Floats) -> Floats:
        return np.array([np.interp(time_s, convoy.time_s, one) for one in values.T]).T

    gap = gaps(run.truth["position"][rows], None) - run.scenario.fleet.length_m
    return _Both(time_s, at(convoy.speed), at(convoy.gap), run.truth["speed"][rows], gap)


def _sheet(both: _Both, convoy: Convoy) -> Sheet:
    car_swing, swing = both.car_speed.std(axis=0), both.speed.std(axis=0)
    car_growth, growth = growths(both.car_speed), growths(both.speed)
    rows: list[tuple[Cell, ...]] = []
    for place, name in enumerate(convoy.cars):
        rows.append(
            (
                place + 1,
                name,
                float(car_swing[place]),
                float(swing[place]),
                float(car_growth[place - 1]) if place else None,
                float(growth[place - 1]) if place else None,
                rms((both.speed - both.car_speed)[:, place]),
                rms((both.gap - both.car_gap)[:, place]) if place else None,
            )
        )
    return Sheet(
        name="recorded",
        title="Cars and vehicles",
        columns=("vehicle", "car", "swing, recorded, m/s", "swing, run, m/s", "growth, recorded",
                 "growth, run", "difference of speed, m/s", "difference of gap, m"),
        rows=tuple(rows),
        note="The swing is the standard deviation of the speed, and the growth its ratio to that "
        "of the vehicle ahead. Differences are root mean squares.",
    )  # fmt: skip


def _speeds(both: _Both) -> Figure:
    figure, axes = style.subplots(2, 1, height_in=3.8, sharex=True, sharey=True)
    parts = (("recorded", both.car_speed), ("run", both.speed))
    for axis, (title, speed) in zip(axes, parts, strict=True):
        colours = mpl.colormaps[style.SPEED_MAP](np.linspace(0.15, 1.0, speed.shape[1] - 1))
        for column, colour in zip(speed[:, 1:].T, colours, strict=True):
            axis.plot(both.time_s, column, color=colour, lw=0.9)
        axis.plot(both.time_s, speed[:, 0], color=style.TRUE)
        axis.set_title(title, loc="left")
        axis.set_ylabel("speed, m/s")
    axes[-1].set_xlabel("time, s")
    axes[-1].set_xlim(both.time_s[0], both.time_s[-1])
    return figure


def _swing(both: _Both) -> Figure:
    figure, axis = style.subplots(height_in=2.6)
    place = np.arange(1, both.speed.shape[1] + 1)
    parts = (("recorded", both.car_speed, style.TRUE), ("run", both.speed, style.CYCLE[0]))
    for label, speed, colour in parts:
        axis.plot(place, speed.std(axis=0), "o-", ms=4, color=colour, label=label)
    axis.set_xlabel("vehicle")
    axis.set_ylabel("swing, m/s")
    axis.set_ylim(bottom=0.0)
    style.whole_numbers(axis.xaxis)
    style.legend(axis)
    return figure
