"""The chapter "Faults": what each fault of the scenario cost."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from zenvoy.analysis.chapters.distance_pictures import run_time_to_collision
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.faults import AFTER_S, Cost, Moves, Stretch, costs
from zenvoy.analysis.measures.safety import smallest
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.page.marks import mark
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet
from zenvoy.analysis.page.style import CYCLE, legend, subplots
from zenvoy.links.distance import gaps
from zenvoy.values.wording import spans

_MOST_S: Final = 20.0  # of time to collision that the picture shows


def faults_section(run: Run) -> Section | None:
    """Return a table and a picture of what faults cost; None where the run had none."""
    found = costs(run.events, moves_of(run))
    if not found:
        return None
    return Section(
        title="Faults",
        sheets=(_sheet(run, found),),
        pictures=(
            Picture(
                name="faults",
                caption=(
                    "Smallest gap and time to collision in the fleet, and speed of the slowest and "
                    "the fastest vehicle. Faults are shaded. A fault that costs nothing leaves no "
                    "mark on the lines."
                ),
                draw=lambda: _drawn(run),
            ),
        ),
    )


def moves_of(run: Run) -> Moves:
    """Return the true motion of a run."""
    scenario = run.scenario
    return Moves(
        time_s=run.time_s,
        position=run.truth["position"],
        speed=run.truth["speed"],
        length_m=scenario.fleet.length_m,
        ring_length_m=scenario.ring_length_m,
    )


def _sheet(run: Run, found: list[Cost]) -> Sheet:
    spacing = spacing_of(run.scenario)
    gap = spacing.named("smallest gap", "m")
    return Sheet(
        name="faults",
        title="What faults cost",
        columns=(
            "from, s",
            "to, s",
            "vehicles",
            "fault",
            gap,
            "of vehicle",
            f"before: {gap}",
            "smallest time to collision, s",
            "before: time to collision, s",
            "largest loss of speed, m/s",
            "before: loss of speed, m/s",
            "collisions",
        ),
        rows=tuple(_row(run, cost) for cost in found),
        note=f"Over all vehicles, while the fault is in force and {AFTER_S:g} s after it. "
        "“Before” is a stretch of the same length up to its begin, or as much of it as there is. "
        "A loss of speed counts from the begin of the stretch. Where other things happen in either "
        "stretch, their cost counts too.",
    )


def _row(run: Run, cost: Cost) -> tuple[Cell, ...]:
    spacing = spacing_of(run.scenario)
    fault, before, during = cost
    return (
        fault.start_s,
        fault.end_s if np.isfinite(fault.end_s) else None,
        spans(fault.vehicles),
        fault.text,
        spacing.shown(during.gap_m),
        during.vehicle,
        None if before is None else spacing.shown(before.gap_m),
        _collision_time(during),
        None if before is None else _collision_time(before),
        during.slower_mps,
        None if before is None else before.slower_mps,
        during.collisions,
    )


def _collision_time(stretch: Stretch) -> float | None:
    return stretch.collision_time_s if np.isfinite(stretch.collision_time_s) else None


def _drawn(run: Run) -> Figure:
    figure, axes = subplots(3, height_in=6.0, sharex=True)
    marked, spacing = happenings(run), spacing_of(run.scenario)
    gap = spacing.shown(gaps(run.truth["position"], run.scenario.ring_length_m))
    ttc, speed = run_time_to_collision(run), run.truth["speed"]
    lines = (
        (spacing.named("smallest gap", "m"), [("", np.nanmin(gap, axis=1))]),
        ("time to collision, s", [("", smallest(ttc))]),
        ("speed, m/s", [("slowest", speed.min(axis=1)), ("fastest", speed.max(axis=1))]),
    )
    for one, (label, curves) in zip(axes, lines, strict=True):
        for colour, (name, values) in zip(CYCLE, curves, strict=False):
            shown = np.where(np.isfinite(values), values, np.nan)
            one.plot(run.time_s, shown, color=colour, label=name or None)
        one.set_xlim(run.time_s[0], run.time_s[-1])
        one.set_ylabel(label)
        mark(one, marked)
        legend(one)
    axes[1].set_ylim(0.0, _MOST_S)
    axes[-1].set_xlabel("time, s")
    return figure
