"""The pictures of the page on real convoys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from zenvoy.analysis.measures.growth import Median
from zenvoy.analysis.page import style
from zenvoy.analysis.page.section import Picture
from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.studies.convoys.comparison import Compared
from zenvoy.studies.convoys.penetration import EQUIPPED, SHARES
from zenvoy.studies.convoys.tables import RECORDED, mean_shares, of_setting, sources

_PANELS: Final = ("FM", "BCM", "PBCM")


def pictures(found: Compared) -> list[Picture]:
    """Return the pictures of the page, in its order."""
    shown = chosen(found)
    return [
        Picture(
            name="one-run",
            caption=(
                f"Speeds in {shown.name}: the recorded cars, the law that fits cars of today best, "
                "fitted to each of them, and laws of Zenvoy behind the same leader. All begin with "
                "the recorded gaps and speeds. Black: the leader; bright: the last vehicle."
            ),
            draw=lambda: _drawn_run(found, shown),
        ),
        Picture(
            name="growth",
            caption=(
                "Median growth of the swing from vehicle to vehicle, with 95 % intervals over the "
                "pairs of vehicles. Above 1, speeds swing more from vehicle to vehicle. Laws have "
                "settled before the recorded drive begins."
            ),
            draw=lambda: _drawn_growth(found),
        ),
        Picture(
            name="shares",
            caption=(
                f"Growth of the swing per vehicle against the share of vehicles with {EQUIPPED} "
                f"among cars of today ({found.best}, fitted to each). Means over the recordings, "
                "with 95 % intervals. Left: begun as recorded. Right: settled before the drive."
            ),
            draw=lambda: _drawn_shares(found),
        ),
    ]


def chosen(found: Compared) -> Convoy:
    """Return the recording in which the last car swings most."""
    return max(found.convoys, key=lambda convoy: float(convoy.speed[:, -1].std()))


def _drawn_run(found: Compared, convoy: Convoy) -> Figure:
    wanted = (RECORDED, f"{found.best}, fitted", *_PANELS)
    of_name = {source.name: source for source in sources(found, settled=False)}
    some = [of_name[name] for name in wanted if name in of_name]
    figure, axes = style.subplots(len(some), 1, height_in=0.5 + 1.3 * len(some), sharex=True,
                                  sharey=True)  # fmt: skip
    for axis, source in zip(axes, some, strict=True):
        speed = source.motions[convoy.name].speed
        time_s = np.arange(len(speed)) * convoy.period_s
        colours = mpl.colormaps[style.SPEED_MAP](np.linspace(0.15, 1.0, speed.shape[1] - 1))
        for column, colour in zip(speed[:, 1:].T, colours, strict=True):
            axis.plot(time_s, column, color=colour, lw=0.9)
        axis.plot(time_s, speed[:, 0], color=style.TRUE, lw=1.2)
        swing = speed[:, -1].std()
        axis.set_title(f"{source.name}: the last vehicle swings by {swing:.2f} m/s", loc="left")
        axis.set_ylabel("speed, m/s")
    axes[-1].set_xlabel("time, s")
    axes[-1].set_xlim(0.0, convoy.time_s[-1])
    return figure


def _drawn_growth(found: Compared) -> Figure:
    some = sources(found, settled=True)
    figure, axis = style.subplots(height_in=3.4)
    width = 0.8 / len(found.settings)
    for number, setting in enumerate(found.settings):
        medians = [of_setting(found, source, setting) for source in some]
        at = np.arange(len(some)) + (number + 0.5) * width - 0.4
        _bars(axis, at, medians, style.CYCLE[number % len(style.CYCLE)], setting or "not told")
    axis.axhline(1.0, color=style.THEORY, ls="--", lw=0.9)
    axis.set_xticks(range(len(some)), [source.name for source in some], rotation=30, ha="right")
    axis.set_ylabel("median growth")
    style.figure_legend(figure, axis)
    return figure


def _bars(axis: Any, at: Any, medians: Sequence[Median], colour: str, label: str) -> None:
    middle = np.array([median.median for median in medians])
    low = np.array([median.median - median.low for median in medians])
    high = np.array([median.high - median.median for median in medians])
    reach = np.nan_to_num([low, high])
    axis.errorbar(at, middle, reach, fmt="o", ms=4, capsize=2, lw=1.0, color=colour, label=label)


def _drawn_shares(found: Compared) -> Figure:
    figure, axes = style.subplots(1, 2, height_in=3.0, sharey=True)
    percent = 100.0 * np.array(SHARES)
    for axis, settled in zip(axes, (False, True), strict=True):
        for all_beacon, mark, label in (
            (True, "o-", "all send beacons"),
            (False, "x--", "only equipped ones send beacons"),
        ):
            means = mean_shares(found, settled=settled, all_beacon=all_beacon)
            half = np.nan_to_num([0.5 * (mean.high - mean.low) for mean in means])
            axis.errorbar(percent, [mean.mean for mean in means], half, fmt=mark, ms=4, capsize=2,
                          lw=1.0, color=style.CYCLE[0 if all_beacon else 1],
                          label=label)  # fmt: skip
        axis.axhline(1.0, color=style.THEORY, ls="--", lw=0.9)
        axis.set_title("settled" if settled else "begun as recorded", loc="left")
        axis.set_xlabel("equipped, %")
    axes[0].set_ylabel("growth per vehicle")
    style.figure_legend(figure, axes[0])
    return figure
