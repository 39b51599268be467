"""The chapter "Motion" of a report: how the fleet moved, in tables and pictures."""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np

from zenvoy.analysis.chapters.distance_pictures import (
    LONGEST_S,
    WINDOW_S,
    collision_time,
    distance_bars,
    headways,
    run_time_to_collision,
)
from zenvoy.analysis.chapters.motion_figures import figures_of_merit, of_headway
from zenvoy.analysis.chapters.motion_pictures import (
    heat_map,
    snapshots,
    space_time,
)
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.instants import PAPER_S, instants, of_paper
from zenvoy.analysis.measures.metrics import max_distance, min_distance
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.measures.spans import distances, disturbances, spans
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet
from zenvoy.links.distance import gaps

Row = tuple[Cell, ...]

_TITLE: Final = "Motion"


def motion_section(run: Run) -> Section:
    """Return tables and pictures of a run's motion; only a note where no cycle was logged."""
    if len(run.time_s) < 2:
        return Section(title=_TITLE, notes=("No cycle was logged, so there is no motion to show.",))
    return Section(
        title=_TITLE,
        sheets=(_distances(run), *_speeds(run), figures_of_merit(run)),
        pictures=tuple(_pictures(run)),
        notes=tuple(_notes(run)),
    )


def _distances(run: Run) -> Sheet:
    time_s, spacing = run.time_s, spacing_of(run.scenario)
    gap = spacing.shown(gaps(run.truth["position"], run.scenario.ring_length_m))
    smallest, largest, mean = min_distance(gap), max_distance(gap), np.nanmean(gap, axis=1)
    rows: list[Row] = []
    for span in spans(disturbances(run.events), float(time_s[-1])):
        pair = distances(span, time_s, smallest, largest)
        if pair is not None:
            middle = float(mean[span.rows(time_s)].mean())
            rows.append((span.name.replace("_", " "), pair[0], middle, pair[1]))
    return Sheet(
        name="motion-distances",
        title="Distances",
        columns=(
            "span",
            *(spacing.named(name, "m") for name in ("MinDistance", "mean gap", "MaxDistance")),
        ),
        rows=tuple(rows),
        note="MinDistance and MaxDistance are the means of the three smallest and the three "
        f"largest gaps, {spacing.of_gaps}. Before a disturbance and at the end they are means over "
        "5 s. In the dip they are extremes from the first disturbance until 30 s after the last.",
    )


def _speeds(run: Run) -> list[Sheet]:
    rows = [
        (at_s, float(run.truth["speed"][row].mean()), float(run.truth["speed"][row].std()))
        for at_s, row in instants(run)
    ]
    if not rows:
        return []
    return [
        Sheet(
            name="motion-speeds",
            title=f"Speeds at {_which(run)}",
            columns=("time, s", "mean speed, m/s", "spread of speed, m/s"),
            rows=tuple(rows),
            note="The spread is the standard deviation over the vehicles.",
        )
    ]


def _pictures(run: Run) -> list[Picture]:
    ring = run.scenario.ring_length_m is not None
    seam = " A line that leaves at the top returns at the bottom." if ring else ""
    frame = "" if ring else ", with positions relative to the middle of the fleet"
    pictures = [
        Picture(
            name="motion-space-time",
            caption="Position of every vehicle over time, coloured by its speed. The upper panel "
            "shows the whole run, the lower panel the time around the first disturbance"
            f"{frame}.{seam} A wave of slow traffic shows as a dark band. A band that falls to "
            "the right moves against the traffic.",
            draw=partial(space_time, run),
        ),
        Picture(
            name="motion-heat-map",
            caption="Speed of every vehicle over time. An even colour is a fleet in steady motion.",
            draw=partial(heat_map, run),
        ),
        Picture(
            name="motion-gaps",
            caption="MinDistance and MaxDistance, the means of the three smallest and the three "
            "largest gaps. Error bars show mean and standard deviation of these three gaps over "
            f"{WINDOW_S:g} s or a fortieth of the run, whichever is longer. They cover both the "
            f"differences between the three and their changes over time.{_of_gaps(run)}",
            draw=partial(distance_bars, run),
        ),
        *_nearness(run),
        Picture(
            name="motion-time-headway",
            caption="Distribution of the time headway over all moving vehicles and all times."
            f"{of_headway(run)}",
            draw=partial(headways, run),
        ),
    ]
    if instants(run):
        caption = f"Speed of every vehicle at {_which(run)}."
        pictures.insert(
            2, Picture(name="motion-snapshots", caption=caption, draw=partial(snapshots, run))
        )
    return pictures


def _of_gaps(run: Run) -> str:
    """Return a sentence on how gaps are measured; "" if they are from front to front."""
    words = spacing_of(run.scenario).words
    return f" Gaps are measured {words}." if words else ""


def _nearness(run: Run) -> list[Picture]:
    """Return the picture of the time to collision, if any is short enough to be shown."""
    if float(np.fmin.reduce(run_time_to_collision(run), axis=None)) >= LONGEST_S:
        return []
    return [
        Picture(
            name="motion-time-to-collision",
            caption="The upper panel shows the smallest time to collision of the fleet. The lower "
            "panel shows the share of vehicles for which it is under 4 s and under 1.5 s, which "
            "are the dashed lines in the upper panel.",
            draw=partial(collision_time, run),
        )
    ]


def _which(run: Run) -> str:
    """Return a description of the instants of the snapshots."""
    if of_paper(run):
        return "the instants that the paper uses"
    return f"instants from the {'first disturbance' if disturbances(run.events) else 'start'} on"


def _notes(run: Run) -> list[str]:
    notes = []
    if not disturbances(run.events):
        notes.append("No vehicle was disturbed, so there is no dip.")
    missing = [f"{at_s:g}" for at_s in PAPER_S if at_s > run.time_s[-1]]
    if missing and of_paper(run):
        notes.append(f"The run ends before {' and '.join(missing)} s, so snapshots are missing.")
    return notes
