"""The figures of merit in the chapter "Motion": safety, comfort and throughput."""

from __future__ import annotations

import numpy as np

from zenvoy.analysis.chapters.distance_pictures import THRESHOLDS_S, run_time_to_collision
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.emissions import consumption
from zenvoy.analysis.measures.motion import (
    at_limits,
    counted_flow,
    crossings,
    flow_by_density,
    jerk,
    rms,
)
from zenvoy.analysis.measures.safety import share_below, time_exposed, time_headway, time_integrated
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.bus import messages_pb2 as pb
from zenvoy.links.distance import gaps
from zenvoy.scenarios import roster

Row = tuple[Cell, ...]


def figures_of_merit(run: Run) -> Sheet:
    """Return the sheet of a run's safety, comfort and throughput."""
    return Sheet(
        name="motion-figures",
        title="Figures of merit",
        columns=("figure", "unit", "value"),
        rows=tuple(_safety(run) + _comfort(run) + _throughput(run)),
        note="Time to collision is the gap between bumpers divided by the closing speed."
        f"{of_headway(run)} TET and "
        "TIT are time exposed and time integrated (Minderhoud and Bovy 2001), summed over "
        "vehicles. Fuel and CO₂ are for a Euro 4 petrol car on a flat road, as SUMO computes them "
        "for HBEFA3/PC_G_EU4.",
    )


def _safety(run: Run) -> list[Row]:
    period_s = run.scenario.period_ns * 1e-9
    gap = gaps(run.truth["position"], run.scenario.ring_length_m)
    ttc, spacing = run_time_to_collision(run), spacing_of(run.scenario)
    headway = time_headway(gap, run.truth["speed"])
    known = headway[~np.isnan(headway)]
    least = float(np.fmin.reduce(ttc, axis=None))
    rows: list[Row] = [
        (spacing.named("smallest gap"), "m", spacing.shown(float(np.nanmin(gap)))),
        ("collisions", "", sum(event.kind == pb.EVENT_COLLISION for event in run.events)),
        ("smallest time to collision", "s", least if np.isfinite(least) else None),
    ]
    for threshold_s in THRESHOLDS_S:
        below = f"time to collision below {threshold_s:g} s"
        rows += [
            (f"{below}, share", "%", 100.0 * share_below(ttc, threshold_s)),
            (f"{below}, exposed (TET)", "s", time_exposed(ttc[1:], threshold_s, period_s)),
            (f"{below}, integrated (TIT)", "s²", time_integrated(ttc[1:], threshold_s, period_s)),
        ]
    return [
        *rows,
        ("smallest time headway", "s", float(known.min()) if known.size else None),
        ("mean time headway", "s", float(known.mean()) if known.size else None),
    ]


def _comfort(run: Run) -> list[Row]:
    acceleration = run.truth["acceleration"][1:]  # row k is the mean over the period before t_k
    limits = [one.limits for one in roster(run.scenario)]
    rows: list[Row] = [
        ("time at the acceleration limits", "%", 100.0 * at_limits(acceleration, limits).mean()),
        ("acceleration, RMS", "m/s²", rms(acceleration)),
    ]
    if len(acceleration) > 1:
        rows.append(("jerk, RMS", "m/s³", rms(jerk(acceleration, run.scenario.period_ns * 1e-9))))
    return rows


def _throughput(run: Run) -> list[Row]:
    time_s, truth, ring = run.time_s, run.truth, run.scenario.ring_length_m
    point_m = 0.0 if ring else float(truth["position"][0, 0])
    passed = crossings(time_s, truth["position"], point_m, ring)
    counted = counted_flow(passed, float(time_s[-1] - time_s[0]) if ring else None)
    density = flow_by_density(truth["position"], truth["speed"], ring).mean()
    spent = consumption(truth["speed"][1:], truth["acceleration"][1:])
    return [
        ("mean speed", "m/s", float(truth["speed"].mean())),
        ("flow, density × mean speed", "vehicles/h", float(density)),
        ("flow, counted at a point", "vehicles/h", counted),
        ("fuel", "l/100 km", spent.fuel_l_per_100km if spent else None),
        ("CO₂", "g/km", spent.co2_g_per_km if spent else None),
    ]


def of_headway(run: Run) -> str:
    """Return a sentence on the gap of the headway where others are not from front to front."""
    words = spacing_of(run.scenario).words
    return " Time headway is the gap from front to front divided by the speed." if words else ""
