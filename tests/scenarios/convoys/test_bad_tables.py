"""A fault in the table of another recording is one line that names the place."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import zenvoy
from tests.recorded_convoys import CARS, long_text, platoon, wide_text

WIDE, LONG = wide_text(platoon(10.0)), long_text(platoon(10.0))
BY_COLUMN = ("--time", "t_ms", "--time-unit", "ms", "--speed", "v_{} [km/h]", "--position", "x_{}")
BY_ROW = ("--time", "time", "--vehicle", "id", "--position", "x", "--speed", "v", "--unit", "m/s")


UNITS = "m/s, km/h, mph, knots"
COLUMNS = ", ".join([*(f"v_{car} [km/h]" for car in CARS), *(f"x_{car}" for car in CARS)])
FAULTS: Final[dict[str, tuple[str, tuple[str, ...], str]]] = {
    "no such column": (
        LONG,
        ("--time", "time", "--vehicle", "id", "--position", "s", "--speed", "v", "--unit", "m/s"),
        "--position: 's' is not a column; allowed: of time, id, x, v  (t.csv, line 1)",
    ),
    "no such columns": (
        WIDE,
        ("--time", "t_ms", "--unit", "km/h", "--speed", "v_{}", "--position", "s_{}"),
        f"--position: 's_{{}}' is the name of no column; allowed: of t_ms, {COLUMNS}"
        "  (t.csv, line 1)",
    ),
    "empty": ("", BY_ROW, "empty  (t.csv)"),
    "no header": ("a", BY_ROW, "no line is a header of columns  (t.csv)"),
    "two cars of one name": (
        LONG.replace("0.3,CAR_B", "0.2,CAR_B"),
        BY_ROW,
        "time: two rows of 'CAR_B' have the time 0.2 s  (t.csv, line 17)",
    ),
    "clock that jumps back": (
        LONG.replace("0.3,CAR_B", "0.1,CAR_B"),
        BY_ROW,
        "time: the clock of 'CAR_B' jumps back: 0.1 s comes after 0.2 s  (t.csv, line 17)",
    ),
    "two columns of one name": (
        WIDE.replace("x_CAR_C", "x_CAR_D"),
        ("--time", "t_ms", "--time-unit", "ms", "--position", "x_{}"),
        "x_{}: 2 cars have the name 'CAR_D'  (t.csv, line 1)",
    ),
    "positions out of order": (
        LONG.replace(",CAR_B,", ",CAR_B,1"),
        (*BY_ROW, "--cars", "LEAD_CAR,CAR_B"),
        "positions of CAR_B and of the car ahead: a gap of -80 m; allowed: at least 0, or "
        "--skip-negative-gaps; 100 more like it  (t.csv, line 5)",
    ),
    "length": (LONG, (*BY_ROW, "--length-m", "0"), "--length-m 0: is not in (0, 1000)"),
}
OPTIONS: Final[dict[str, tuple[str, str]]] = {
    "--time time --vehicle id --speed v": (
        LONG,
        "--gap: not given, nor is a position; allowed: one of the two, or both",
    ),
    "--time t_ms --gap x_{}": (
        WIDE,
        "--speed: not given, nor is a position; allowed: one of the two, or both",
    ),
    "--time t_ms --position x": (
        WIDE,
        "--position: 'x' has not one {}, which stands for the name of a car; allowed: such as "
        "position{}, or the column of cars, with a vehicle",
    ),
    "--time time --vehicle id --position x{}": (
        LONG,
        "--position: 'x{}' has a {}, but a vehicle is given",
    ),
    f"{' '.join(BY_ROW[:-1])} furlongs": (LONG, f"--unit: 'furlongs' is not one of {UNITS}"),
    " ".join(BY_ROW[:-2]): (
        LONG,
        f"--unit: not given, and 'v' names no unit; allowed: one of {UNITS}",
    ),
}
"""Options that do not fit together: the table to which they are given, and what is said of them."""


def assert_refused(folder: Path, text: str, options: Sequence[str], line: str) -> None:
    (folder / "t.csv").write_text(text)
    outcome = zenvoy(folder, "import", "table", "t.csv", *options)
    assert (outcome.code, outcome.out, outcome.err) == (2, "", f"{line}\n")


@pytest.mark.parametrize("fault", FAULTS)
def test_a_bad_table_is_one_line(tmp_path: Path, fault: str) -> None:
    assert_refused(tmp_path, *FAULTS[fault])


@pytest.mark.parametrize("options", OPTIONS)
def test_options_that_do_not_fit_are_one_line(tmp_path: Path, options: str) -> None:
    text, line = OPTIONS[options]
    assert_refused(tmp_path, text, options.split(), line)


@pytest.mark.parametrize("options", [BY_COLUMN, BY_ROW])
def test_the_tables_are_good_without_the_faults(tmp_path: Path, options: tuple[str, ...]) -> None:
    (tmp_path / "t.csv").write_text(WIDE if options is BY_COLUMN else LONG)
    assert zenvoy(tmp_path, "import", "table", "t.csv", *options).code == 0
