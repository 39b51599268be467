"""Numbers in tables have only significant digits, and the same number of them in a column."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.analysis.page.digits import Column, columns, text, texts
from zenvoy.analysis.page.section import Cell, Sheet


def read(written: str) -> float:
    return float(written.replace("−", "-").replace("∞", "inf").replace("\u00a0", ""))


@pytest.mark.parametrize(
    ("column", "expected"),
    [
        ([36.0312, 39.36], ["36.03", "39.36"]),
        ([1.7341, 0.0213], ["1.734", "0.021"]),
        ([123.456, 0.0312, None, math.nan], ["123.46", "0.03", "–", "–"]),  # at least one digit
        ([10.0, 12.0, 500.0], ["10", "12", "500"]),
        ([0.05, 0.1, 0.0], ["0.05", "0.10", "0.00"]),
        ([-0.25, 1.0, math.inf, -math.inf], ["−0.25", "1.00", "∞", "−∞"]),
        ([1e-9, 123.4], ["1.000e−09", "123.4"]),  # of different scales
        ([30.04, "m/s", 0.25], ["30.04", "m/s", "0.25"]),
        ([7_800_000, 9999, -12_345], ["7\u00a0800\u00a0000", "9999", "−12\u00a0345"]),
        ([5_000, 0.3333], ["5000", "0.3333"]),
        ([0.0, 0.0], ["0", "0"]),
        ([-0.0001, 3.5], ["−0.0001", "3.5"]),
        ([-1e-8, 2e-5], ["0.000000", "0.000020"]),
        ([None], ["–"]),
        ([], []),
    ],
)
def test_columns_are_written_as_expected(column: list[Cell], expected: list[str]) -> None:
    assert texts(column) == expected


@pytest.mark.parametrize(
    ("cell", "expected"),
    [
        (12345.678, "12346"),
        (1.5e7, "1.500e+07"),
        (0.00012345, "0.000123"),
        (-2.0, "−2"),
        (299792.458, "299792"),
    ],
)
def test_single_numbers_are_written_as_expected(cell: Cell, expected: str) -> None:
    assert text(cell) == expected


@given(st.lists(st.floats(min_value=1e-3, max_value=1e6), min_size=1))
def test_written_numbers_are_close_to_their_values(column: list[float]) -> None:
    """The largest number is right to 1 in 1,000, and every other has at least one digit."""
    for value, written in zip(column, texts(column), strict=True):
        tolerance = 1e-3 if value == max(column) else 0.51
        assert read(written) == pytest.approx(value, rel=tolerance)


@given(st.lists(st.floats(min_value=0.1, max_value=900.0), min_size=2))
def test_decimal_points_of_a_column_of_one_scale_are_aligned(column: list[float]) -> None:
    assert len({len(written.partition(".")[2]) for written in texts(column)}) == 1


def test_rows_of_different_units_are_written_separately() -> None:
    rows = (("gap", "m", 36.0312, 40.0), ("frames", "", 12_000, None), ("lost", "%", 0.25, 120.5))
    sheet = Sheet(name="s", title="S", columns=("figure", "unit", "a", "b"), rows=rows)
    assert columns(sheet, 2) == [
        Column("figure", False, ["gap", "frames"]),
        Column("unit", False, ["m", ""]),
        Column("a", True, ["36.03", "12\u00a0000"]),
        Column("b", True, ["40.00", "–"]),
    ]
    assert [column.cells[2] for column in columns(sheet, 9)] == ["lost", "%", "0.25", "120.50"]


def test_rows_of_one_unit_are_written_alike() -> None:
    rows = ((1, 36.0312, "FM"), (2, 120.5, "BCM"), (3, None, "BCM"))
    sheet = Sheet(name="s", title="S", columns=("vehicle", "gap, m", "model"), rows=rows)
    assert columns(sheet, 3) == [
        Column("vehicle", True, ["1", "2", "3"]),
        Column("gap, m", True, ["36.0", "120.5", "–"]),
        Column("model", False, ["FM", "BCM", "BCM"]),
    ]


def test_a_single_row_of_many_columns_is_transposed() -> None:
    titles = ("technology", "sent", "delivered, %", "a, m", "b, m", "c, s", "d, s")
    rows = (("lte-a-pro", 12_000, 79.9938, None, 30.04, 0.5, 1.0),)
    sheet = Sheet(name="s", title="S", columns=titles, rows=rows)
    assert columns(sheet, 9) == [
        Column("figure", False, list(titles)),
        Column("value", True, ["lte-a-pro", "12\u00a0000", "79.99", "–", "30.04", "0.5", "1"]),
    ]
    few = Sheet(name="s", title="S", columns=titles[:6], rows=(rows[0][:6],))
    assert [column.title for column in columns(few, 9)] == list(titles[:6])
