"""The tables of the page on real convoys."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from zenvoy.analysis.measures.growth import Median, growth_per_vehicle, growths, median_of
from zenvoy.analysis.measures.statistics import Mean, mean_of
from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.studies.convoys.behind import Motion, recorded
from zenvoy.studies.convoys.comparison import FITTED, Compared, held_errors
from zenvoy.studies.convoys.penetration import SHARES, Point, stopping_share

RECORDED = "recorded"


class Source(NamedTuple):
    """Whoever drives behind the leaders: a name, and the motion by recording."""

    name: str
    motions: dict[str, Motion]


def sources(found: Compared, *, settled: bool) -> list[Source]:
    """Return the recorded cars, the fitted ones, and the laws, begun as recorded or settled."""
    real = Source(RECORDED, {one.name: recorded(one) for one in found.convoys})
    fitted = [
        Source(f"{law}, fitted", {name: m for (of, name), m in found.chains.items() if of == law})
        for law in FITTED
    ]
    laws = [
        Source(
            model,
            {
                one.recording: one.settled if settled else one.begun
                for one in found.behind
                if one.model == model
            },
        )
        for model in found.models
    ]
    return [real, *([] if settled else fitted), *laws]


def recordings_sheet(found: Compared) -> Sheet:
    """Return a row for each recording."""
    rows = []
    for convoy in found.convoys:
        swing = convoy.speed.std(axis=0)
        rows.append(
            (
                convoy.name,
                convoy.setting or None,
                len(convoy.cars),
                float(convoy.time_s[-1]),
                float(convoy.speed[:, 0].mean()),
                float(swing[0]),
                float(swing[-1]),
                growth_per_vehicle(convoy.speed),
                median_of(growths(convoy.speed)).median,
            )
        )
    return Sheet(
        name="recordings",
        title="The recordings",
        columns=("recording", "driven by", "cars", "duration, s", "mean speed, m/s",
                 "swing of the leader, m/s", "swing of the last car, m/s", "growth per vehicle",
                 "median growth"),
        rows=tuple(rows),
        note="The swing is the standard deviation of the speed. Growth per vehicle: the geometric "
        "mean from the leader to the last car. Median growth: of the ratios from car to car.",
    )  # fmt: skip


def of_setting(found: Compared, source: Source, setting: str) -> Median:
    """Return the median growth from vehicle to vehicle over all recordings of a setting."""
    names = [convoy.name for convoy in found.convoys if convoy.setting == setting]
    return median_of(np.concatenate([growths(source.motions[name].speed) for name in names]))


def growth_sheet(found: Compared, *, settled: bool) -> Sheet:
    """Return the median growth of whoever drives behind the leaders, by setting."""
    rows = [
        (source.name, *(_told(of_setting(found, source, setting)) for setting in found.settings))
        for source in sources(found, settled=settled)
    ]
    begun = "settled before the recorded drive" if settled else "begun as recorded"
    return Sheet(
        name="growth-settled" if settled else "growth-begun",
        title=f"Median growth of the swing from vehicle to vehicle, {begun}",
        columns=("behind the leaders", *(setting or "not told" for setting in found.settings)),
        rows=tuple(rows),
        note="In brackets: 95 % intervals over all pairs of vehicles of the recordings.",
    )


def gaps_sheet(found: Compared) -> Sheet:
    """Return the gaps that the laws need for what they do."""
    rows = []
    for source in sources(found, settled=False):
        gaps = [motion.gap for motion in source.motions.values()]
        spread = float(np.median(np.concatenate([gap.std(axis=0) for gap in gaps])))
        smallest, largest = min(gap.min() for gap in gaps), max(gap.max() for gap in gaps)
        last = float(np.median([one.speed[:, -1].std() for one in source.motions.values()]))
        collisions = sum(motion.collisions for motion in source.motions.values())
        told = None if source.name == RECORDED else collisions
        rows.append((source.name, last, spread, float(smallest), float(largest), told))
    return Sheet(
        name="gaps",
        title="Gaps from bumper to bumper over all recordings, begun as recorded",
        columns=("behind the leaders", "median swing of the last vehicle, m/s",
                 "median spread of a gap, m", "smallest gap, m", "largest gap, m", "collisions"),
        rows=tuple(rows),
    )  # fmt: skip


def fits_sheet(found: Compared) -> Sheet:
    """Return how well each law fits the cars of each setting."""
    rows: list[tuple[Cell, ...]] = []
    for setting in found.settings:
        names = [convoy.name for convoy in found.convoys if convoy.setting == setting]
        for law in FITTED:
            some = [found.fits[law, name] for name in names]
            held = [error for one in some for error in held_errors(one)]
            ends = [bool(fit.at_bound) for one in some for fit in one.fits]
            rows.append(
                (
                    setting or "not told",
                    law,
                    len(ends),
                    float(np.median([pair.gap.std() for one in some for pair in one.pairs])),
                    float(np.median([fit.rms_gap_m for one in some for fit in one.fits])),
                    float(np.median(held)) if held else None,
                    float(100.0 * np.mean(ends)),
                )
            )
    return Sheet(
        name="fits",
        title="Laws fitted to each car",
        columns=("driven by", "law", "cars", "spread of a gap, m", "error of a gap, m",
                 "held out: error of a gap, m", "with a number at an end of its range, %"),
        rows=tuple(rows),
        note="Medians over the cars. The error is a root mean square over a recording; held out, "
        "over other recordings of the same setting with the same car.",
    )  # fmt: skip


def shares_sheet(found: Compared, *, settled: bool, all_beacon: bool) -> Sheet:
    """Return the growth per vehicle of each recording against the share of equipped vehicles."""
    rows: list[tuple[Cell, ...]] = []
    for convoy in found.convoys:
        growth = shares_of(found, convoy.name, settled=settled, all_beacon=all_beacon)
        stops = stopping_share(growth)
        told = "never" if stops is None else f"{100.0 * stops:.0f} %"
        rows.append((convoy.name, convoy.setting or None, *growth, told))
    start = "settled" if settled else "begun"
    others = "beacons" if all_beacon else "silent"
    return Sheet(
        name=f"shares-{start}-{others}",
        title="Growth of the swing per vehicle with a share of equipped vehicles",
        columns=("recording", "driven by", *(f"{100.0 * share:.0f} %" for share in SHARES),
                 "stopped from"),
        rows=tuple(rows),
        note=f"Means over {found.seeds} seeds, which draw who is equipped.",
    )  # fmt: skip


def shares_of(found: Compared, name: str, *, settled: bool, all_beacon: bool) -> list[float]:
    """Return the growth per vehicle of a recording at each share, as a mean over seeds."""
    points = (Point(name, share, all_beacon, settled) for share in SHARES)
    return [float(np.mean(found.mixed[point].growth)) for point in points]


def mean_shares(found: Compared, *, settled: bool, all_beacon: bool) -> list[Mean]:
    """Return the growth per vehicle at each share, as a mean over recordings."""
    of_all = [
        shares_of(found, convoy.name, settled=settled, all_beacon=all_beacon)
        for convoy in found.convoys
    ]
    return [mean_of(list(at_share)) for at_share in zip(*of_all, strict=True)]


def _told(median: Median) -> str:
    if np.isnan(median.low):
        return f"{median.median:.2f}"
    return f"{median.median:.2f} ({median.low:.2f} to {median.high:.2f})"
