"""Pictures of positions and speeds: space-time diagram, heat map, snapshots."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.instants import around_first, instants
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.page.marks import ABOVE_BARS_PT, mark
from zenvoy.analysis.page.speed_map import speed_map
from zenvoy.analysis.page.style import CYCLE, SPEED_MAP, legend, subplots, whole_numbers

Floats = NDArray[np.float64]

_BEFORE_S: Final = 10.0  # the lower panel begins this long before the first disturbance
_PART_S: Final = 90.0  # shortest time that the lower panel shows

# A page cannot show more than these; more would only make files large and drawing slow.
_MAX_LINES: Final = 80
_MAX_PIECES: Final = 40_000
_MAX_COLUMNS: Final = 1_400


def space_time(run: Run) -> Figure:
    """Draw position over time, a line per vehicle, coloured by speed: the whole run, and a part.

    On the open road the positions of the part are relative to the middle of the fleet.
    """
    time_s, ring = run.time_s, run.scenario.ring_length_m
    figure, axes = subplots(2, height_in=6.4)
    lines = _lines(axes[0], run, (float(time_s[0]), float(time_s[-1])), moving=False)
    _lines(axes[1], run, around_first(run, _BEFORE_S, _PART_S), moving=not ring)
    axes[0].set_ylabel("position on the ring, m" if ring else "position, m")
    axes[1].set_ylabel("position on the ring, m" if ring else "ahead of the fleet's middle, m")
    found = happenings(run)
    for one in axes:
        mark(one, found, image=True)
        legend(one, above_pt=ABOVE_BARS_PT)
    axes[1].set_xlabel("time, s")
    figure.colorbar(lines, ax=axes, label="speed, m/s", fraction=0.04, pad=0.02)
    return figure


def _lines(axes: Any, run: Run, span: tuple[float, float], *, moving: bool) -> LineCollection:
    """Draw a span of time, in the frame of the road or in one that moves with the fleet."""
    vehicles = slice(None, None, -(-run.vehicles // _MAX_LINES))
    rows = np.flatnonzero((run.time_s >= span[0]) & (run.time_s <= span[1]))
    many = len(rows) * len(range(run.vehicles)[vehicles])
    rows = rows[:: max(1, -(-many // _MAX_PIECES))]
    time_s = run.time_s[rows]
    position = run.truth["position"][rows]
    if moving:
        position = position - position.mean(axis=1, keepdims=True)
    position = position[:, vehicles]
    speed = run.truth["speed"][rows][:, vehicles]
    pieces: Any
    pieces, values = pieces_of(time_s, position, speed, run.scenario.ring_length_m)
    lines = LineCollection(
        pieces,
        array=values,
        cmap=SPEED_MAP,
        norm=_scale(run),
        linewidths=1.0,
        rasterized=True,
        capstyle="butt",
        antialiaseds=False,
    )
    axes.add_collection(lines)
    axes.set_xlim(*span)
    axes.set_ylim(*_extent(run, position))
    axes.grid(visible=False)
    return lines


def pieces_of(
    time_s: Floats, position: Floats, speed: Floats, ring_length_m: float | None
) -> tuple[Floats, Floats]:
    """Return straight pieces (P, 2, 2) of (time, position), and the speed on each (P,).

    A piece that crosses the seam of the ring is drawn at both ends.
    """
    lap = np.floor(position / ring_length_m) if ring_length_m else np.zeros(position.shape)
    start, end = position[:-1], position[1:]
    times = np.broadcast_to(time_s[:, None], position.shape)
    whole = np.stack([times[:-1], start, times[1:], end], axis=-1)
    mean = (speed[:-1] + speed[1:]) / 2.0
    if ring_length_m is None:
        return whole.reshape(-1, 2, 2), mean.ravel()
    before, after = whole.copy(), whole.copy()
    before[..., (1, 3)] -= (lap[:-1] * ring_length_m)[..., None]
    after[..., (1, 3)] -= (lap[1:] * ring_length_m)[..., None]
    over = lap[1:] > lap[:-1]
    pieces = np.concatenate([before.reshape(-1, 2, 2), after[over].reshape(-1, 2, 2)])
    return pieces, np.concatenate([mean.ravel(), mean[over]])


def _extent(run: Run, position: Floats) -> tuple[float, float]:
    length_m = run.scenario.ring_length_m
    return (0.0, length_m) if length_m else (float(position.min()), float(position.max()))


def _scale(run: Run) -> Normalize:
    """Return the colour scale for speeds that all pictures of a run share."""
    speed = run.truth["speed"]
    return Normalize(float(speed.min()), float(speed.max()))


def heat_map(run: Run) -> Figure:
    """Draw the speed of every vehicle over time (paper Fig. heatmap)."""
    time_s, speed = run.time_s, run.truth["speed"]
    step = -(-len(speed) // _MAX_COLUMNS)
    figure, axes = subplots(height_in=3.2)
    image = speed_map(axes, time_s, speed[::step], _scale(run))
    mark(axes, happenings(run), image=True)
    legend(axes, above_pt=ABOVE_BARS_PT)
    figure.colorbar(image, ax=axes, label="speed, m/s", fraction=0.04, pad=0.02)
    axes.set_xlabel("time, s")
    axes.set_ylabel("vehicle")
    return figure


def snapshots(run: Run) -> Figure:
    """Draw the speed of every vehicle at some instants (paper Fig. pic_vs)."""
    rows = instants(run)
    figure, axes = subplots(len(rows), height_in=0.6 + 1.25 * len(rows), sharex=True, sharey=True)
    vehicles = np.arange(1, run.vehicles + 1)
    for one, (at_s, row) in zip(np.atleast_1d(axes), rows, strict=True):
        speed = run.truth["speed"][row]
        one.plot(vehicles, speed, "o-", color=CYCLE[0], ms=3, lw=0.8)
        one.set_title(
            f"{at_s:g} s: mean {speed.mean():.2f} m/s, spread {speed.std():.2f} m/s",
            loc="left",
        )
    whole_numbers(np.atleast_1d(axes)[-1].xaxis)
    np.atleast_1d(axes)[-1].set_xlabel("vehicle")
    np.atleast_1d(axes)[-1].set_xlim(0.0, run.vehicles + 1.0)
    figure.supylabel("speed, m/s", fontsize="medium")
    return figure
