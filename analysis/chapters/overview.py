"""The first chapter of a report: the summary, and the run in one picture."""

from __future__ import annotations

from functools import partial
from typing import Final

from zenvoy.analysis.chapters.overview_picture import overview
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.metrics import meaningful_r2
from zenvoy.analysis.measures.spacing import FRONTS, Spacing, spacing_of
from zenvoy.analysis.measures.summary import Summary
from zenvoy.analysis.page.happenings import timeline
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet

Merit = tuple[str, str, Cell]
"""A figure of merit: its name, its unit ("" for counts), its value."""

MERITS: Final = (
    "MinDistance and MaxDistance are the means of the three smallest and the three largest gaps. "
    "Before a disturbance and at the end they are means over 5 s. In the dip they are extremes "
    "from the first disturbance until 30 s after the last. R² compares the error with the spread "
    "(standard deviation) of the truth. It is left out where the error is larger, as in a fleet in "
    "steady motion, because it would be below 0. A frame counts once for each receiver in range."
)
"""The note under a table of figures of merit."""
_CAPTION: Final = (
    "The run at a glance. The top panel shows the speed of every vehicle over time; a wave is a "
    "band that crosses the vehicles. The middle panel shows MinDistance and MaxDistance, the means "
    "of the three smallest and the three largest gaps; they meet when the string settles. The "
    "bottom panel shows the gap ahead of one vehicle: measured by its radar, true and, under a law "
    "that predicts, estimated by its filter."
)


def overview_section(run: Run, summary: Summary) -> Section:
    """Return summary and overview of a run that has motion to show."""
    sheet = Sheet(
        name="summary",
        title="Summary",
        columns=("figure", "unit", "value"),
        rows=merits(summary, spacing_of(run.scenario)),
        note=MERITS,
    )
    picture = Picture(name="overview", caption=_CAPTION, draw=partial(overview, run))
    happened = timeline(run)
    sheets = (sheet, happened) if happened else (sheet,)
    return Section(title="Overview", sheets=sheets, pictures=(picture,))


def merits(summary: Summary, spacing: Spacing = FRONTS) -> tuple[Merit, ...]:
    """Return the figures of a summary that apply to its run, in order, with gaps as `spacing`."""
    found = [*_distances(summary, spacing), *_agreement(summary), *_counts(summary)]
    return tuple(merit for merit in found if merit[2] is not None)


def _distances(summary: Summary, spacing: Spacing) -> list[Merit]:
    smallest = summary.get("smallest_gap_m")
    shown = None if smallest is None else spacing.shown(smallest)
    found: list[Merit] = [(spacing.named("smallest gap"), "m", shown)]
    for span, distance in summary.get("distance_m", {}).items():
        title = span.replace("_", " ")
        if distance is not None:
            for name, key in (("MinDistance", "min"), ("MaxDistance", "max")):
                shown = spacing.shown(distance[key])
                found.append((spacing.named(f"{name}, {title}"), "m", shown))
    spread = summary.get("speed_spread_at_100_s_mps")
    return [*found, ("spread of speed at 100 s", "m/s", spread)]


def _agreement(summary: Summary) -> list[Merit]:
    found: list[Merit] = []
    for quantity, unit in (("speed", "m/s"), ("gap", "m")):
        fits = {kind: fit for kind, fit in (summary.get(quantity) or {}).items() if fit}
        for kind, fit in fits.items():
            found.append((f"RMSE of the {kind} {quantity}", unit, fit["rmse"]))
            found.append((f"R² of the {kind} {quantity}", "", meaningful_r2(fit["r2"])))
        spread = max((fit["spread"] for fit in fits.values()), default=None)
        found.append((f"spread of the true {quantity}", unit, spread))
    return found


def _counts(summary: Summary) -> list[Merit]:
    frames = summary["frames"]
    share = 100.0 * frames["lost"] / frames["sent"] if frames["sent"] else None
    return [
        ("collisions", "", summary["collisions"]),
        ("fallbacks to FM", "", summary["fallbacks"]),
        ("frames sent", "", frames["sent"]),
        ("frames delivered", "", frames["delivered"]),
        ("frames delivered late", "", frames["late"]),
        ("frames lost", "", frames["lost"]),
        ("share of frames lost", "%", share),
        ("latency, mean", "ms", frames["latency_mean_ms"]),
        ("latency, 95th percentile", "ms", frames["latency_p95_ms"]),
    ]
