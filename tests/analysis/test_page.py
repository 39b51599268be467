"""The HTML page is well-formed, self-contained, and safe for any text."""

from __future__ import annotations

import re
from base64 import b64decode
from dataclasses import replace
from typing import Final

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.pages import read
from zenvoy.analysis.page import style
from zenvoy.analysis.page.drawing import Drawn, drawn
from zenvoy.analysis.page.html import MAX_ROWS, Page, render
from zenvoy.analysis.page.section import Picture, Section, Sheet

NASTY: Final = "<script>alert(\"1\")</script> & 'so' {{ 7 * 7 }} </style> --> http"


def line() -> Figure:
    figure, axes = style.subplots(height_in=1.5)
    axes.plot([0, 1, 2], [0.0, 1.0, 0.5])
    return figure


def map_of_noise() -> Figure:
    """Draw a picture that is small as PNG and large as SVG."""
    figure, axes = style.subplots(height_in=1.5)
    x, y = np.random.default_rng(1).normal(size=(2, 3000))
    axes.plot(x, y, ".")
    return figure


LINE: Final = Picture(name="line", caption="A line. It goes up, then down.", draw=line)
SHEET: Final = Sheet(
    name="gaps",
    title="Gaps",
    columns=("vehicle", "gap, m", "model"),
    rows=((1, 36.0312, "FM"), (2, None, NASTY)),
    note="Of two vehicles.",
)
SECTION: Final = Section(title="Motion", sheets=(SHEET,), pictures=(LINE,), notes=("No braking.",))
PAGE: Final = Page(
    title="paper/case-15, seed 1",
    lead="Forty vehicles",
    facts=(("seed", "1"), ("how it ended", "complete")),
    notes=("the log is cut: read up to 3 s of 6 s",),
    sections=(SECTION, Section(title="Empty")),
    folded=(("Scenario", "seed: 1\n"),),
    made=("zenvoy analyze run.mcap",),
)


@pytest.fixture(scope="module")
def pictures() -> dict[str, Drawn]:
    return {"line": drawn(LINE)}


def test_a_page_has_all_its_parts(pictures: dict[str, Drawn]) -> None:
    page = read(render(PAGE, pictures))
    assert page.texts("h1") == page.texts("title") == ["paper/case-15, seed 1"]
    assert page.texts("h2") == ["Read this first", "Contents", "Motion", "Empty"]
    assert page.texts("li") == ["the log is cut: read up to 3 s of 6 s"]
    assert page.texts("a") == ["Motion", "Empty"]
    assert (page.texts("dt"), page.texts("dd")) == (["seed", "how it ended"], ["1", "complete"])
    assert page.texts("th") == ["vehicle", "gap, m", "model", "1", "2"]
    assert page.texts("td")[:3] == ["36.03", "FM", "–"]
    assert page.texts("caption") == ["Gaps"]
    assert page.texts("figcaption") == ["A line. It goes up, then down."]
    assert page.texts("pre") == ["seed: 1"]
    assert page.texts("p")[0] == "Forty vehicles"
    assert set(page.texts("p")) >= {"No braking.", "Of two vehicles.", "zenvoy analyze run.mcap"}


def test_notes_come_first(pictures: dict[str, Drawn]) -> None:
    html = render(PAGE, pictures)
    assert html.index("the log is cut") < html.index("how it ended") < html.index("Table 1")
    assert "Read this first" not in render(replace(PAGE, notes=()), pictures)


def test_numbers_are_right_aligned(pictures: dict[str, Drawn]) -> None:
    html = render(PAGE, pictures)
    assert '<th scope="col" class="n">gap, m</th>' in html
    assert '<td class="n">36.03</td>' in html
    assert '<th scope="col" class="w">model</th>' in html  # its texts are long


def test_every_text_is_escaped() -> None:
    """This holds wherever a text of a scenario, a log or a chapter can appear."""
    nasty = Picture(name="line", caption=NASTY, draw=line)
    sheet = Sheet(name="s", title=NASTY, columns=(NASTY,), rows=((NASTY,),), note=NASTY)
    page = Page(
        title=NASTY,
        lead=NASTY,
        facts=((NASTY, NASTY),),
        notes=(NASTY,),
        sections=(Section(title=NASTY, sheets=(sheet,), pictures=(nasty,), notes=(NASTY,)),),
        folded=((NASTY, NASTY),),
        made=(NASTY,),
    )
    html = render(page, {"line": drawn(nasty)})
    parsed = read(html)
    assert "<script" not in html
    for tag in ("title", "h1", "h2", "dt", "dd", "li", "th", "caption", "summary", "pre", "p"):
        assert NASTY in parsed.texts(tag), tag
    assert parsed.all("img", "alt") == [NASTY]


def test_a_picture_is_shown_in_its_smaller_form() -> None:
    dots = Picture(name="dots", caption="Noise.", draw=map_of_noise)
    forms = {"line": drawn(LINE), "dots": drawn(dots)}
    section = Section(title="Both", pictures=(LINE, dots))
    page = read(render(Page(title="t", sections=(section,)), forms))
    shown = page.all("img", "src")
    assert len(forms["line"].svg) < len(forms["line"].png)
    assert len(forms["dots"].png) < len(forms["dots"].svg)
    kinds = [source.partition(";")[0] for source in shown]
    assert kinds == ["data:image/svg+xml", "data:image/png"]
    assert b64decode(shown[0].partition(",")[2]) == forms["line"].svg
    assert b64decode(shown[1].partition(",")[2]) == forms["dots"].png
    assert page.all("img", "width") == ["672", "672"]


def test_a_long_table_names_the_place_of_its_rest() -> None:
    rows = tuple((number, number * 0.5) for number in range(1, MAX_ROWS + 101))
    sheet = Sheet(name="long", title="Long", columns=("vehicle", "x, m"), rows=rows)
    page = read(render(Page(title="t", sections=(Section(title="s", sheets=(sheet,)),)), {}))
    assert len(page.texts("td")) == MAX_ROWS
    assert page.texts("p") == [
        f"Only the first {MAX_ROWS} of {MAX_ROWS + 100} rows are shown; long.csv has all."
    ]


def test_names_that_would_collide_are_refused(pictures: dict[str, Drawn]) -> None:
    for twice in (Section(title="s", sheets=(SHEET,)), Section(title="s", pictures=(LINE,))):
        with pytest.raises(ValueError, match=r"more than one has the name (gaps|line)"):
            render(replace(PAGE, sections=(SECTION, twice)), pictures)


def test_equal_data_give_equal_bytes(pictures: dict[str, Drawn]) -> None:
    again = {"line": drawn(LINE)}
    assert again == pictures
    assert render(PAGE, again) == render(PAGE, pictures)
    assert not re.search(rb"20\d\d-\d\d-\d\d", pictures["line"].svg)


def test_characters_that_the_font_lacks_cause_no_warning() -> None:
    """Warnings are errors here, and dollars are shown as dollars."""

    def named() -> Figure:
        figure, axes = style.subplots(height_in=1.5)
        axes.plot([0, 1], label=style.plain("_车队 $\\frac$"))
        axes.legend()
        assert len(axes.get_legend().get_texts()) == 1
        return figure

    assert drawn(Picture(name="named", caption="A name.", draw=named)).png


@pytest.mark.parametrize(
    "html", ["<p><b></p></b>", "</p>", '<p id="a"></p><p id="a"></p>', '<a href="http://x">x</a>']
)
def test_a_bad_page_would_be_found(html: str) -> None:
    with pytest.raises(AssertionError):
        read(html)


def test_texts_wrap_and_none_is_cut_off(pictures: dict[str, Drawn]) -> None:
    """A fingerprint may break anywhere, and only numbers stay on one line."""
    sheet = Sheet(name="s", title="S", columns=("run", "fingerprint"), rows=(("a", "0" * 16),))
    html = render(replace(PAGE, sections=(replace(SECTION, sheets=(sheet,)),)), pictures)
    assert '<td class="b">0000000000000000</td>' in html
    style = html.partition("<style>")[2].partition("@media print")[0]
    unbroken = [line for line in style.splitlines() if "nowrap" in line]
    assert all(line.startswith(".n ") for line in unbroken)
    assert re.search(r"\.b \{ overflow-wrap: anywhere; \}", style)
