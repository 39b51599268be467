"""Chapters on a terminal keep numbers and words whole at any width."""

from __future__ import annotations

from io import StringIO
from typing import Final

import pytest
from rich.console import Console

from zenvoy.analysis.page.section import Section, Sheet
from zenvoy.cli.sections import MAX_ROWS, print_section

WIDE: Final = Sheet(
    name="wide",
    title="A wide table.",
    columns=("figure", "unit", *(f"{name} of the run, m" for name in "abcdefgh")),
    rows=(
        ("smallest gap", "m", *(12_345.678 * number for number in range(1, 9))),
        ("a long name of a quantity [b]that[/b] must fold", "", *range(8)),
    ),
    note="A note of more words than there is room for in a line of a narrow terminal.",
)


def printed(section: Section, width: int) -> str:
    """Return what a terminal of this width shows."""
    file = StringIO()
    print_section(Console(file=file, width=width, color_system=None), section)
    return file.getvalue()


@pytest.mark.parametrize("width", [200, 80, 60])
def test_every_number_is_printed_at_any_width(width: int) -> None:
    text = printed(Section(title="Chapter", sheets=(WIDE,), notes=("A note.",)), width)
    lines = text.splitlines()
    assert max(map(len, lines)) <= width
    assert "…" not in text
    for number in range(1, 9):
        assert f" {12_345.678 * number:.0f}" in text
    assert {"Chapter", "  A note.", "A wide table."} <= {line.rstrip() for line in lines}
    words = " ".join(text.split())
    for letter in "abcdefgh":
        assert f"{letter} of" in words
    assert "[b]that[/b]" in words


def test_a_table_that_is_too_wide_repeats_the_names_of_its_rows() -> None:
    lines = printed(Section(title="C", sheets=(WIDE,)), 80).splitlines()
    heads = sum(line.startswith("figure ") for line in lines)
    assert heads > 1
    assert sum(line.startswith("smallest gap") for line in lines) == heads


def test_titles_are_printed_in_full() -> None:
    titles = tuple(f"share of {word} that are late, %" for word in ("beacons", "commands", "all"))
    rows = tuple((number, 1.5, 2.5, 3.5) for number in range(3))
    sheet = Sheet(name="s", title="S.", columns=("vehicle", *titles), rows=rows)
    lines = printed(Section(title="C", sheets=(sheet,)), 60).splitlines()
    rule = next(number for number, line in enumerate(lines) if line.startswith("──"))
    head = " ".join(lines[3:rule]).split()
    for word in ("beacons", "commands", "all"):
        assert head.count(word) == 1
    for word in ("share", "of", "that", "are", "late,", "%"):
        assert head.count(word) == 3


def test_a_long_table_names_the_place_of_its_rest() -> None:
    rows = tuple((number, 0.5) for number in range(1, MAX_ROWS + 11))
    sheet = Sheet(name="long", title="Long.", columns=("vehicle", "x, m"), rows=rows)
    text = printed(Section(title="C", sheets=(sheet,)), 80)
    assert f"Only the first {MAX_ROWS} of {MAX_ROWS + 10} rows are shown; long.csv has all." in text
    assert f"\n{' ' * 5}{MAX_ROWS} " in text
    assert f" {MAX_ROWS + 1} " not in text


def test_an_empty_table_has_only_its_head() -> None:
    sheet = Sheet(name="none", title="None.", columns=("vehicle", "x, m"), rows=())
    assert "vehicle" in printed(Section(title="C", sheets=(sheet,)), 80)


def test_empty_rows_and_columns_are_left_out() -> None:
    sheet = Sheet(
        name="s",
        title="S",
        columns=("figure", "unit", "measured", "theory"),
        rows=(("a", "m", 1.0, None), ("b", "m", None, None), ("c", "", "yes", None)),
    )
    filled = sheet.without_empty()
    assert filled is not None
    assert filled.columns == ("figure", "unit", "measured")
    assert filled.rows == (("a", "m", 1.0), ("c", "", "yes"))
    nothing = Sheet(name="s", title="S", columns=("figure", "value"), rows=(("a", None),))
    assert nothing.without_empty() is None
    empty = Sheet(name="s", title="S", columns=("figure", "value"), rows=(), note="None differ.")
    assert empty.without_empty() == empty
