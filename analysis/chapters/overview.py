"""The first chapter of a report: the figures of the summary, and the run in one picture."""

from __future__ import annotations

from functools import partial
from typing import Final

from zenvoy.analysis.chapters.overview_picture import overview
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.metrics import telling
from zenvoy.analysis.measures.summary import Summary
from zenvoy.analysis.page.happenings import timeline
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet

Merit = tuple[str, str, Cell]
"""A figure of merit: what it is, its unit ("" for counts), its value."""

MERITS: Final = (
    "MinDistance and MaxDistance are the means of the three smallest and of the three largest "
    "gaps: before a disturbance and at the end as means over 5 s, in its dip as extremes from the "
    "first one until 30 s after the last. R² compares an error with the spread of the truth, its "
    "standard deviation. It is left out where the error is the larger of the two, as in a fleet in "
    "steady motion: it would be below 0, and say no more. A frame counts once for each receiver "
    "in range."
)
"""What stands under a table of figures of merit."""
_CAPTION: Final = (
    "The run at a glance. Top: speed of every vehicle over time; a wave shows as a band that "
    "crosses the vehicles. Middle: MinDistance and MaxDistance, the means of the three smallest "
    "and of the three largest gaps; on a string that settles they meet. Bottom: the gap ahead of "
    "one vehicle as its radar reads it, as it is and, under PBCM, as its filter estimates it."
)


def overview_section(run: Run, summary: Summary) -> Section:
    """Summary and overview of a run that has motion to show."""
    sheet = Sheet(
        name="summary",
        title="Summary",
        columns=("figure", "unit", "value"),
        rows=merits(summary),
        note=MERITS,
    )
    picture = Picture(name="overview", caption=_CAPTION, draw=partial(overview, run))
    happened = timeline(run)
    sheets = (sheet, happened) if happened else (sheet,)
    return Section(title="Overview", sheets=sheets, pictures=(picture,))


def merits(summary: Summary) -> tuple[Merit, ...]:
    """The figures of a summary that apply to its run, in order."""
    found = [*_distances(summary), *_agreement(summary), *_counts(summary)]
    return tuple(merit for merit in found if merit[2] is not None)


def _distances(summary: Summary) -> list[Merit]:
    found: list[Merit] = [("smallest gap", "m", summary.get("smallest_gap_m"))]
    for span, distance in summary.get("distance_m", {}).items():
        title = span.replace("_", " ")
        if distance is not None:
            found.append((f"MinDistance, {title}", "m", distance["min"]))
            found.append((f"MaxDistance, {title}", "m", distance["max"]))
    spread = summary.get("speed_spread_at_100_s_mps")
    return [*found, ("spread of speed at 100 s", "m/s", spread)]


def _agreement(summary: Summary) -> list[Merit]:
    found: list[Merit] = []
    for quantity, unit in (("speed", "m/s"), ("gap", "m")):
        fits = {kind: fit for kind, fit in (summary.get(quantity) or {}).items() if fit}
        for kind, fit in fits.items():
            found.append((f"RMSE of the {kind} {quantity}", unit, fit["rmse"]))
            found.append((f"R² of the {kind} {quantity}", "", telling(fit["r2"])))
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
