"""Draws each picture once, and saves it in all formats."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from io import BytesIO
from typing import Final
from warnings import catch_warnings, filterwarnings

from matplotlib.figure import Figure

from zenvoy.analysis.page import style
from zenvoy.analysis.page.section import Picture

DPI: Final = 150


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """A picture as PNG and SVG, and its size in inches."""

    png: bytes
    svg: bytes
    width_in: float
    height_in: float


def drawn(picture: Picture) -> Drawn:
    """Draw a picture; equal data give equal bytes.

    Characters that the font lacks, such as Chinese in a scenario's name, become boxes.
    """
    with style.look(), catch_warnings():
        filterwarnings("ignore", "Glyph .* missing from font")
        figure = picture.draw()
        _lay_out(figure)
        png, svg = _saved(figure, "png"), _saved(figure, "svg")
    width_in, height_in = figure.get_size_inches()
    return Drawn(png=png, svg=svg, width_in=float(width_in), height_in=float(height_in))


def picture_files(pictures: Iterable[Picture]) -> dict[str, bytes]:
    """Draw pictures, and return the PNG and the SVG of each by name of file."""
    files: dict[str, bytes] = {}
    for picture in pictures:
        drawing = drawn(picture)
        files |= {f"{picture.name}.png": drawing.png, f"{picture.name}.svg": drawing.svg}
    return files


def in_markdown(picture: Picture) -> list[str]:
    """Return the lines of Markdown that show the PNG of a picture above its caption."""
    return [f"![{picture.name}]({picture.name}.png)", "", f"*{picture.caption}*", ""]


def _lay_out(figure: Figure) -> None:
    """Lay out axes and labels once; otherwise each save would draw everything to do so."""
    engine = figure.get_layout_engine()
    if engine is not None:
        figure.set_dpi(DPI)
        engine.execute(figure)
        figure.set_layout_engine(None)


def _saved(figure: Figure, form: str) -> bytes:
    file = BytesIO()
    # Rasterised parts of an SVG have the resolution of the PNG.
    dated = {"Date": None} if form == "svg" else {}
    figure.savefig(file, format=form, dpi=DPI, metadata=dated)
    return file.getvalue()
