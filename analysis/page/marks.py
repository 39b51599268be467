"""Marks on a time axis what happened: spans are shaded, switches are dashed lines.

In a picture that fills its axes, such as a heat map, shading would change the colours. There the
spans are bars along the upper edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, Literal

from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.transforms import Affine2D, ScaledTranslation, blended_transform_factory

from zenvoy.analysis.page.happenings import Happening

Span = tuple[float, float]

# Colour, opacity and name of each kind of span.
_LOOKS: Final = {
    "brake": ("#D55E00", 0.22, "brake"),
    "trace": ("#CC79A7", 0.18, "speed trace"),
    "manoeuvre": ("#56B4E9", 0.25, "manoeuvre"),
    "outage": ("#F0E442", 0.45, "outage"),
    "rule": ("#009E73", 0.18, "channel rule"),
    "fault": ("#E69F00", 0.28, "fault"),
}
_WHOLE: Final = (0.0, 1.0)  # all of the height, or the width, of the axes
_BAR_PT: Final = (1.5, 5.5)  # lower and upper edge of a bar, above the axes
ABOVE_BARS_PT: Final = 9.0


def mark(
    axes: Any, found: Sequence[Happening], *, image: bool = False, along: Literal["x", "y"] = "x"
) -> None:
    """Mark what happened within the limits of the time axis (`along`), which must be final.

    With `image`, spans are bars above the axes. Every mark has a label for the legend.
    """
    low, high = axes.get_xlim() if along == "x" else axes.get_ylim()
    for kind, (colour, opacity, name) in _LOOKS.items():
        spans = united(
            [
                (max(low, happening.start_s), min(high, happening.end_s))
                for happening in found
                if happening.kind == kind
                and happening.start_s < happening.end_s
                and happening.start_s < high
                and happening.end_s > low
                and not (happening.start_s <= low and happening.end_s >= high)
            ]
        )
        if spans:
            boxes = [_box(span, _BAR_PT if image else _WHOLE, along) for span in spans]
            shade = PolyCollection(
                boxes,
                transform=_over(axes) if image else _transform(axes, along),
                clip_on=not image,
                zorder=0.1,
                label=name,
                color=colour,
                alpha=1.0 if image else opacity,
                linewidth=0.5,
            )
            axes.add_collection(shade, autolim=False)
    times = [at_s for at_s in map(_switched, found) if at_s is not None and low < at_s < high]
    if times:
        look: dict[str, Any] = {"linewidth": 0.8, "linestyle": "--"}
        lines = LineCollection(
            [_box((at_s, at_s), _WHOLE, along)[:2] for at_s in times],
            transform=_transform(axes, along),
            color="white" if image else "black",
            **look,
        )
        axes.add_collection(lines, autolim=False)
        axes.plot([], [], color="black", label="switch", **look)  # white is invisible in a legend


def _switched(happening: Happening) -> float | None:
    """Return when a switch, or a manoeuvre without a ramp, happened, s; None for other things."""
    at_once = happening.kind == "manoeuvre" and happening.start_s == happening.end_s
    return happening.start_s if happening.kind == "switch" or at_once else None


def united(spans: Sequence[Span]) -> list[Span]:
    """Join spans that overlap or touch."""
    found: list[Span] = []
    for start, end in sorted(spans):
        if found and start <= found[-1][1]:
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        else:
            found.append((start, end))
    return found


def _box(span: Span, across: Span, along: Literal["x", "y"]) -> list[tuple[float, float]]:
    """Return the corners of a rectangle: a span of time, and one across it."""
    (start, end), (low, high) = span, across
    corners = [(start, low), (start, high), (end, high), (end, low)]
    return corners if along == "x" else [(across, time) for time, across in corners]


def _transform(axes: Any, along: Literal["x", "y"]) -> Any:
    return axes.get_xaxis_transform() if along == "x" else axes.get_yaxis_transform()


def _over(axes: Any) -> Any:
    """Return the transform with times on x, and points above the axes on y."""
    points = Affine2D().scale(1.0 / 72.0) + axes.figure.dpi_scale_trans
    top = ScaledTranslation(0.0, 1.0, axes.transAxes)
    return blended_transform_factory(axes.transData, points + top)
