"""A fault in the table of another recording is one line that names the place."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.recorded_convoys import CARS, long_text, platoon, wide_text

WIDE, LONG = wide_text(platoon(10.0)), long_text(platoon(10.0))
BY_COLUMN = ("--time", "t_ms", "--time-unit", "ms", "--speed", "v_{} [km/h]", "--position", "x_{}")
BY_ROW = ("--time", "time", "--vehicle", "id", "--position", "x", "--speed", "v", "--unit", "m/s")


@pytest.mark.parametrize(
    ("text", "options", "line"),
    [
        pytest.param(
            LONG,
            (
                "--time",
                "time",
                "--vehicle",
                "id",
                "--position",
                "s",
                "--speed",
                "v",
                "--unit",
                "m/s",
            ),
            "--position: 's' is not a column; allowed: of time, id, x, v  (t.csv, line 1)",
            id="no such column",
        ),
        pytest.param(
            WIDE,
            ("--time", "t_ms", "--unit", "km/h", "--speed", "v_{}", "--position", "s_{}"),
            "--position: 's_{}' is the name of no column; allowed: of t_ms, "
            + ", ".join([*(f"v_{car} [km/h]" for car in CARS), *(f"x_{car}" for car in CARS)])
            + "  (t.csv, line 1)",
            id="no such columns",
        ),
        pytest.param("", BY_ROW, "empty  (t.csv)", id="empty"),
        pytest.param("a", BY_ROW, "no line is a header of columns  (t.csv)", id="no header"),
        pytest.param(
            LONG.replace("0.3,CAR_B", "0.2,CAR_B"),
            BY_ROW,
            "time: two rows of 'CAR_B' have the time 0.2 s  (t.csv, line 17)",
            id="two cars of one name",
        ),
        pytest.param(
            LONG.replace("0.3,CAR_B", "0.1,CAR_B"),
            BY_ROW,
            "time: the clock of 'CAR_B' jumps back: 0.1 s comes after 0.2 s  (t.csv, line 17)",
            id="clock that jumps back",
        ),
        pytest.param(
            WIDE.replace("x_CAR_C", "x_CAR_D"),
            ("--time", "t_ms", "--time-unit", "ms", "--position", "x_{}"),
            "x_{}: 2 cars have the name 'CAR_D'  (t.csv, line 1)",
            id="two columns of one name",
        ),
        pytest.param(
            LONG.replace(",CAR_B,", ",CAR_B,1"),
            (*BY_ROW, "--cars", "LEAD_CAR,CAR_B"),
            "positions of CAR_B and of the car ahead: a gap of -80 m; allowed: at least 0, or "
            "--skip-negative-gaps; 100 more like it  (t.csv, line 5)",
            id="positions out of order",
        ),
        pytest.param(
            LONG,
            ("--time", "time", "--vehicle", "id", "--speed", "v"),
            "--gap: not given, nor is a position; allowed: one of the two, or both",
            id="no gap",
        ),
        pytest.param(
            WIDE,
            ("--time", "t_ms", "--gap", "x_{}"),
            "--speed: not given, nor is a position; allowed: one of the two, or both",
            id="no speed",
        ),
        pytest.param(
            WIDE,
            ("--time", "t_ms", "--position", "x"),
            "--position: 'x' has not one {}, which stands for the name of a car; allowed: such as "
            "position{}, or the column of cars, with a vehicle",
            id="no mark",
        ),
        pytest.param(
            LONG,
            ("--time", "time", "--vehicle", "id", "--position", "x{}"),
            "--position: 'x{}' has a {}, but a vehicle is given",
            id="a mark too many",
        ),
        pytest.param(
            LONG,
            (*BY_ROW[:-1], "furlongs"),
            "--unit: 'furlongs' is not one of m/s, km/h, mph, knots",
            id="no such unit",
        ),
        pytest.param(
            LONG,
            BY_ROW[:-2],
            "--unit: not given, and 'v' names no unit; allowed: one of m/s, km/h, mph, knots",
            id="no unit",
        ),
        pytest.param(
            LONG, (*BY_ROW, "--length-m", "0"), "--length-m 0: is not in (0, 1000)", id="length"
        ),
    ],
)
def test_a_bad_table_is_one_line(
    tmp_path: Path, text: str, options: tuple[str, ...], line: str
) -> None:
    (tmp_path / "t.csv").write_text(text)
    outcome = zenvoy(tmp_path, "import", "table", "t.csv", *options)
    assert (outcome.code, outcome.out, outcome.err) == (2, "", f"{line}\n")


@pytest.mark.parametrize("options", [BY_COLUMN, BY_ROW])
def test_the_tables_are_good_without_the_faults(tmp_path: Path, options: tuple[str, ...]) -> None:
    (tmp_path / "t.csv").write_text(WIDE if options is BY_COLUMN else LONG)
    assert zenvoy(tmp_path, "import", "table", "t.csv", *options).code == 0
