"""Renders sections and pictures as one HTML page that needs no other file."""

from __future__ import annotations

from base64 import b64encode
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from zenvoy.analysis.page.digits import columns
from zenvoy.analysis.page.drawing import Drawn
from zenvoy.analysis.page.section import Picture, Section, Sheet

MAX_ROWS: Final = 200  # of a table on the page; its CSV has them all
_CSS_PX_PER_IN: Final = 96
_HERE: Final = Path(__file__).parent


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """The contents of a page.

    `facts` are names with values. `notes` hold what a reader must know first. `folded` texts open
    on demand. `made` says how the page was made, in lines.
    """

    title: str
    lead: str = ""
    facts: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()
    sections: tuple[Section, ...] = ()
    folded: tuple[tuple[str, str], ...] = ()
    made: tuple[str, ...] = ()


def render(page: Page, pictures: Mapping[str, Drawn]) -> str:
    """Return the page as HTML, with all texts escaped. `pictures` are the drawn ones by name.

    Raises ValueError where two sheets or two pictures share a name.
    """
    _refuse_doubles(page.sections)
    css = Markup((_HERE / "page.css").read_text(encoding="utf-8"))  # no user's text is in it
    tables, figures = count(1), count(1)
    chapters = [
        {
            "title": section.title,
            "notes": section.notes,
            "tables": [
                _table(shown, next(tables))
                for sheet in section.sheets
                if (shown := sheet.without_empty()) is not None
            ],
            "figures": [
                _figure(picture, pictures[picture.name], next(figures))
                for picture in section.pictures
            ],
        }
        for section in page.sections
    ]
    return _template().render(page=page, css=css, chapters=chapters)


@cache
def _template() -> Template:
    return Environment(
        loader=FileSystemLoader(_HERE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    ).get_template("page.jinja")


def _table(sheet: Sheet, number: int) -> dict[str, Any]:
    shown = columns(sheet, MAX_ROWS)
    notes = [sheet.note] if sheet.note else []
    if len(sheet.rows) > MAX_ROWS:
        of = f"{MAX_ROWS} of {len(sheet.rows)} rows"
        notes.append(f"Only the first {of} are shown; {sheet.name}.csv has all.")
    return {
        "name": sheet.name,
        "number": number,
        "title": sheet.title,
        "columns": shown,
        "rows": list(zip(*(column.cells for column in shown), strict=True)),
        "notes": notes,
    }


def _figure(picture: Picture, drawn: Drawn, number: int) -> dict[str, Any]:
    """Return a figure in the smaller of its formats; the first sentence is its alternative text."""
    kind, data = min(("svg+xml", drawn.svg), ("png", drawn.png), key=lambda form: len(form[1]))
    first, stop, _ = picture.caption.partition(". ")
    return {
        "name": picture.name,
        "number": number,
        "caption": picture.caption,
        "alt": first + stop.strip(),
        "data": f"data:image/{kind};base64,{b64encode(data).decode()}",
        "width": round(drawn.width_in * _CSS_PX_PER_IN),
        "height": round(drawn.height_in * _CSS_PX_PER_IN),
    }


def _refuse_doubles(sections: Sequence[Section]) -> None:
    for things in ([section.sheets for section in sections], [s.pictures for s in sections]):
        names = Counter(thing.name for group in things for thing in group)
        twice = [name for name, times in names.items() if times > 1]
        if twice:
            raise ValueError(f"more than one has the name {', '.join(twice)}")
