"""Figures of a run, drawn without a display."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log import Facts, LogError, Table, read_facts, read_fleet
from zenvoy.analysis.metrics import gaps, max_distance, min_distance

# Okabe and Ito's palette: told apart by colour-blind readers too.
_BLUE: Final = "#0072B2"
_VERMILION: Final = "#D55E00"
_SKY: Final = "#56B4E9"


def overview(path: Path) -> Figure:
    """Speed of every vehicle, MinDistance and MaxDistance, and what the filter makes of a gap.

    Raises LogError where the log has no motion to show.
    """
    facts = read_facts(path)
    fleet = read_fleet(path)
    truth = fleet["/fleet/truth"]
    if not truth or len(truth["time_ns"]) < 2:
        raise LogError(f"{path}: no cycle was logged")
    figure = Figure(figsize=(8.0, 8.6), layout="constrained")
    heat, distance, link = figure.subplots(3, 1)
    time_s = truth["time_ns"] * 1e-9
    gap = gaps(truth["position"], facts.scenario.ring_length_m)
    _speeds(figure, heat, time_s, truth["speed"])
    _distances(distance, time_s, gap)
    _one_link(link, facts, fleet, time_s, gap)
    run = facts.run
    figure.suptitle(f"{run['scenario']}, seed {run['seed']}, {run['vehicles']} vehicles")
    return figure


def _speeds(figure: Figure, axes: Any, time_s: NDArray[Any], speed: NDArray[Any]) -> None:
    n = speed.shape[1]
    extent = (time_s[0], time_s[-1], 0.5, n + 0.5)
    image = axes.imshow(
        speed.T, aspect="auto", origin="lower", extent=extent, cmap="cividis", interpolation="none"
    )
    figure.colorbar(image, ax=axes, label="speed, m/s")
    axes.set_xlabel("time, s")
    axes.set_ylabel("vehicle")


def _distances(axes: Any, time_s: NDArray[Any], gap: NDArray[Any]) -> None:
    axes.plot(time_s, max_distance(gap), color=_VERMILION, lw=0.9, label="MaxDistance")
    axes.plot(time_s, min_distance(gap), color=_BLUE, lw=0.9, label="MinDistance")
    axes.set_xlim(time_s[0], time_s[-1])
    axes.set_xlabel("time, s")
    axes.set_ylabel("mean of three gaps, m")
    axes.legend(frameon=False, ncols=2, loc="upper right")


def _one_link(
    axes: Any, facts: Facts, fleet: dict[str, Table], time_s: NDArray[Any], gap: NDArray[Any]
) -> None:
    """The gap ahead of the vehicle behind the first one that brakes, over a minute from then."""
    brakes = facts.scenario.brakes
    braking = min(brakes, key=lambda brake: brake.at_s) if brakes else None
    vehicle = (braking.vehicle if braking else 1) % gap.shape[1] + 1
    start_s = max(0.0, braking.at_s - 5.0) if braking else 0.0
    radar, estimate = fleet["/fleet/radar"], fleet["/fleet/estimate"]
    shown = np.flatnonzero((time_s >= start_s) & (time_s <= start_s + 60.0))
    shown = shown[shown < min(len(radar.get("cycle", ())), len(estimate.get("cycle", ())))]
    column = vehicle - 1
    if shown.size:
        reading, filtered = radar["gap"][shown, column], estimate["ahead_gap"][shown, column]
        axes.plot(time_s[shown], reading, ".", color=_SKY, ms=3, label="measured")
        axes.plot(time_s[shown], gap[shown, column], color="black", lw=1.6, label="true")
        axes.plot(time_s[shown], filtered, color=_VERMILION, lw=1.0, label="estimated")
        axes.legend(frameon=False, ncols=3, loc="lower right", markerscale=3)
        axes.set_xlim(time_s[shown[0]], time_s[shown[-1]])
    axes.set_xlabel("time, s")
    axes.set_ylabel(f"gap ahead of vehicle {vehicle}, m")
