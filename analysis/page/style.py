"""How figures look: page width, units on axes, colours that colour-blind readers tell apart."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager
from typing import Any, Final

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from zenvoy.laws import builtin

# Okabe and Ito's palette. The same law has the same colour in every figure.
MODEL_COLOURS: Final = {name: law.colour or "#999999" for name, law in builtin().items()}
TRUE: Final = "#000000"
MEASURED: Final = "#56B4E9"
ESTIMATED: Final = "#D55E00"
THEORY: Final = "#7F7F7F"
# For what is no model: runs beside each other, vehicles, quantities.
CYCLE: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# Perceptually even, and the same to a colour-blind reader. Bright is fast.
SPEED_MAP: Final = "cividis"

WIDTH_IN: Final = 7.0  # of a page
_LONG: Final = 30.0
_IN_A_ROW: Final = 5  # entries of a legend
_FONT_PT: Final = 9.0
_RC: Final[dict[Any, Any]] = {
    "font.size": _FONT_PT,
    "axes.titlesize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E5E5E5",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": _FONT_PT,
    "lines.linewidth": 1.2,
    "svg.hashsalt": "zenvoy",  # the same figure gives the same file
}


def look() -> AbstractContextManager[None]:
    """The context in which figures are drawn and saved."""
    return mpl.rc_context(_RC)


def plain(text: str) -> str:
    """A text of the user's for a figure: dollars are dollars, and a legend leaves none out.

    What is no character stands as its number: the files have no place for it.
    """
    text = "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text
    )
    return (" " + text if text.startswith("_") else text).replace("$", r"\$")


def subplots(
    rows: int = 1, columns: int = 1, *, height_in: float, **options: Any
) -> tuple[Figure, Any]:
    """A figure of page width and its axes: (Figure, Axes or array of Axes)."""
    with look():
        figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
        return figure, figure.subplots(rows, columns, **options)


def legend(axes: Any, *, above_pt: float = 2.0, **options: Any) -> None:
    """A legend above the axes, at the right: none ever covers data. No artist, no legend."""
    handles, labels = _told([axes])
    if handles:
        pad = above_pt / _FONT_PT
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": pad}
        axes.legend(handles, labels, **(place | {"ncols": len(handles)} | options))


def figure_legend(figure: Figure, *axes: Any, **options: Any) -> None:
    """One legend for all these axes, above them; what they share is told once."""
    handles, labels = _told(axes)
    if handles:
        columns = min(_IN_A_ROW, len(handles))
        place: dict[str, Any] = {"loc": "outside upper right", "ncols": columns}
        figure.legend(handles, labels, **(place | options))


def _told(axes: Iterable[Any]) -> tuple[list[Any], list[str]]:
    """Artists with labels, the first of each label."""
    told: dict[str, Any] = {}
    for one in axes:
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
            told.setdefault(label, handle)
    return list(told.values()), list(told)


def plain_log(axis: Any) -> None:
    """Ticks of a logarithmic axis (an `XAxis` or `YAxis`) written out: 1, 2, 5, 10, …

    Over more than three decades 1, 10, 100, …: the limits must be final.
    """
    low, high = sorted(axis.get_view_interval())
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high <= 1e3 * low else (1.0,)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def whole_numbers(*axes: Any) -> None:
    """Ticks at integers alone: nobody is vehicle 2.5."""
    for axis in axes:
        axis.set_major_locator(
            MaxNLocator("auto", steps=[1, 2, 5, 10], integer=True, min_n_ticks=1)
        )


def is_long(low: float, high: float) -> bool:
    """Whether values from `low` to `high` need a logarithmic axis: see `long_axis`."""
    return 0.0 < _LONG * low < high


def long_axis(axes: Any, low: float, high: float) -> None:
    """Limits of an x-axis of what is 0 or more, and logarithmic where much would lie at its start.

    That is where `high`, the largest value, is more than 30 times `low`, the smallest above 0.
    What is 0 then stands at the left edge.
    """
    if is_long(low, high):
        axes.set_xscale("log")
        axes.set_xlim(0.7 * low, 1.05 * high)
        plain_log(axes.xaxis)
    else:
        axes.set_xlim(0.0, 1.05 * high if high > 0.0 else 1.0)
