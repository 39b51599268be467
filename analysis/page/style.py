"""The style of figures: page width, legends, axes, and colours that colour-blind people can see."""

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
# For runs, vehicles and quantities, which have no colour of their own.
CYCLE: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# Perceptually uniform, also for colour-blind readers. Bright is fast.
SPEED_MAP: Final = "cividis"

WIDTH_IN: Final = 7.0  # of a page
_LONG: Final = 30.0  # ratio of the largest to the smallest value that needs a logarithmic axis
_LEGEND_COLUMNS: Final = 5
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
    """Return the context in which figures are drawn and saved."""
    return mpl.rc_context(_RC)


def plain(text: str) -> str:
    """Return a user's text so that a figure shows it as it is.

    A dollar does not begin a formula, and a legend does not drop a leading underscore. Control
    characters, which the files cannot hold, are written as escapes.
    """
    text = "".join(
        sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in text
    )
    return (" " + text if text.startswith("_") else text).replace("$", r"\$")


def subplots(
    rows: int = 1, columns: int = 1, *, height_in: float, **options: Any
) -> tuple[Figure, Any]:
    """Return a figure of page width and its axes: (Figure, Axes or array of Axes)."""
    with look():
        figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
        return figure, figure.subplots(rows, columns, **options)


def legend(axes: Any, *, above_pt: float = 2.0, **options: Any) -> None:
    """Add a legend at the upper right, above the axes, where it covers no data."""
    handles, labels = _labelled([axes])
    if handles:
        pad = above_pt / _FONT_PT
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": pad}
        axes.legend(handles, labels, **(place | {"ncols": len(handles)} | options))


def figure_legend(figure: Figure, *axes: Any, **options: Any) -> None:
    """Add one legend above all these axes; labels that they share appear once."""
    handles, labels = _labelled(axes)
    if handles:
        columns = min(_LEGEND_COLUMNS, len(handles))
        place: dict[str, Any] = {"loc": "outside upper right", "ncols": columns}
        figure.legend(handles, labels, **(place | options))


def _labelled(axes: Iterable[Any]) -> tuple[list[Any], list[str]]:
    """Return the artists that have labels, one for each label."""
    artists: dict[str, Any] = {}
    for one in axes:
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
            artists.setdefault(label, handle)
    return list(artists.values()), list(artists)


def plain_log(axis: Any) -> None:
    """Label a logarithmic axis (an `XAxis` or `YAxis`) with plain numbers: 1, 2, 5, 10, …

    An axis of more than three decades gets 1, 10, 100, … The limits must be final.
    """
    low, high = sorted(axis.get_view_interval())
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high <= 1e3 * low else (1.0,)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def whole_numbers(*axes: Any) -> None:
    """Put ticks only at integers, as for numbers of vehicles."""
    for axis in axes:
        axis.set_major_locator(
            MaxNLocator("auto", steps=[1, 2, 5, 10], integer=True, min_n_ticks=1)
        )


def is_long(low: float, high: float) -> bool:
    """Return whether values from `low` to `high` need a logarithmic axis; see `long_axis`."""
    return 0.0 < _LONG * low < high


def long_axis(axes: Any, low: float, high: float) -> None:
    """Set the limits of an x-axis for values of 0 and more, and its scale.

    It is logarithmic if `high`, the largest value, is more than 30 times `low`, the smallest above
    0. Values of 0 are then at the left edge.
    """
    if is_long(low, high):
        axes.set_xscale("log")
        axes.set_xlim(0.7 * low, 1.05 * high)
        plain_log(axes.xaxis)
    else:
        axes.set_xlim(0.0, 1.05 * high if high > 0.0 else 1.0)
