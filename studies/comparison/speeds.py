"""A picture of how each law carries the speed of the head to the tail, in one run."""

from __future__ import annotations

from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.page.section import Picture
from zenvoy.analysis.page.style import THEORY, figure_legend, plain, subplots
from zenvoy.studies.comparison.compared import Comparison
from zenvoy.studies.comparison.laws import ComparedLaw
from zenvoy.studies.sweeps.store import Store

Floats = NDArray[np.float64]

SERIES_SHOWN: Final = ("head_speed_mps", "tail_speed_mps")
"""The time series that the picture needs."""


class Ends(NamedTuple):
    """The speeds of head and tail under a law, (T,) each, m/s."""

    law: ComparedLaw
    time_s: Floats
    head: Floats
    tail: Floats


def speeds(compared: Comparison, store: Store) -> Picture | None:
    """Return the picture for the first seed; None if no vehicle follows a head."""
    seed = compared.results.plan.seeds[0]
    found: list[Ends] = []
    for row in compared.results.rows:
        stored = store.series(row.key, SERIES_SHOWN) if row.seed == seed else None
        if stored is not None and not np.isnan(stored[SERIES_SHOWN[0]]).all():
            law = compared.laws[row.cell.number - 1]
            found.append(Ends(law, stored["time_s"], *(stored[name] for name in SERIES_SHOWN)))
    if not found:
        return None
    same = _same_head(found)
    what = "the head, the same under all laws (grey)" if same else "the head (dashed)"
    caption = f"Speed of {what}, and of the tail under each law, over time with seed {seed}."
    return Picture(name="laws-speeds", caption=caption, draw=partial(_drawn, found, same))


def _same_head(found: list[Ends]) -> bool:
    return all(np.array_equal(one.head, found[0].head) for one in found)


def _drawn(found: list[Ends], same_head: bool) -> Figure:
    figure, axes = subplots(height_in=3.2)
    if same_head:
        axes.plot(found[0].time_s, found[0].head, color=THEORY, lw=2.4, label="head")
    for one in found:
        look: dict[str, Any] = {"color": one.law.colour, "lw": 1.0}
        if not same_head:
            axes.plot(one.time_s, one.head, ls="--", **look)
        axes.plot(one.time_s, one.tail, label=plain(one.law.label), **look)
    axes.set_xlim(0.0, max(float(one.time_s[-1]) for one in found))
    axes.set_xlabel("time, s")
    axes.set_ylabel("speed, m/s")
    figure_legend(figure, axes)
    return figure
