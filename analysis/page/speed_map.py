"""The picture of speeds over time and vehicle, which several chapters and pages show."""

from __future__ import annotations

from typing import Any

from matplotlib.colors import Normalize
from matplotlib.image import AxesImage
from numpy.typing import NDArray

from zenvoy.analysis.page.style import SPEED_MAP, whole_numbers


def speed_map(
    axes: Any, time_s: NDArray[Any], speed: NDArray[Any], scale: Normalize | None = None
) -> AxesImage:
    """Draw speeds, (T, n) m/s, over time (s) and vehicle, and return the image for a colour bar.

    By default the scale is from the lowest to the highest speed.
    """
    image: AxesImage = axes.imshow(
        speed.T,
        aspect="auto",
        origin="lower",
        extent=(time_s[0], time_s[-1], 0.5, speed.shape[1] + 0.5),
        cmap=SPEED_MAP,
        norm=scale,
        interpolation="none",
    )
    axes.grid(visible=False)
    whole_numbers(axes.yaxis)
    return image
