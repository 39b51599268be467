"""How figures look: page width, units on axes, colours that colour-blind readers tell apart."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any, Final

import matplotlib as mpl
from matplotlib.figure import Figure

# Okabe and Ito's palette. The same model has the same colour in every figure.
MODEL_COLOURS: Final = {
    "FM": "#000000",
    "BCM": "#D55E00",
    "MBCM": "#009E73",
    "PBCM": "#0072B2",
    "CACC": "#E69F00",
}
TRUE: Final = "#000000"
MEASURED: Final = "#56B4E9"
ESTIMATED: Final = "#D55E00"
THEORY: Final = "#7F7F7F"
# For what is no model: runs beside each other, vehicles, quantities.
CYCLE: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
# Perceptually even, and the same to a colour-blind reader. Bright is fast.
SPEED_MAP: Final = "cividis"

WIDTH_IN: Final = 7.0  # of a page
_RC: Final[dict[Any, Any]] = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E5E5E5",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "svg.hashsalt": "zenvoy",  # the same figure gives the same file
}


def look() -> AbstractContextManager[None]:
    """The context in which figures are drawn and saved."""
    return mpl.rc_context(_RC)


def plain(text: str) -> str:
    """A text of the user's for a figure: dollars are dollars, and a legend leaves none out."""
    return (" " + text if text.startswith("_") else text).replace("$", r"\$")


def subplots(
    rows: int = 1, columns: int = 1, *, height_in: float, **options: Any
) -> tuple[Figure, Any]:
    """A figure of page width and its axes: (Figure, Axes or array of Axes)."""
    with look():
        figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
        return figure, figure.subplots(rows, columns, **options)
