"""A bad recording is refused with one line for each thing that is wrong with it."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.recorded_convoys import CARS, openacc_text, platoon

Change = Callable[[str], str]
OPENACC = openacc_text(platoon(10.0))


def cell(row: int, column: int, text: str) -> Change:
    """Return a change of one cell; rows count from 1 on, as lines do."""

    def change(table: str) -> str:
        rows = [line.split(",") for line in table.splitlines()]
        rows[row - 1][column] = text
        return "\n".join(map(",".join, rows)) + "\n"

    return change


@pytest.mark.parametrize(
    ("change", "line"),
    [
        pytest.param(
            lambda _: "",
            "empty  (a.csv)",
            id="empty",
        ),
        pytest.param(
            lambda text: text.replace("Time,Speed1", "Zeit,Speed1"),
            "no line is the header Time, Speed1, … of OpenACC  (a.csv)",
            id="no header",
        ),
        pytest.param(
            lambda text: "".join(text.splitlines(keepends=True)[:6]),
            "there is no row below the header  (a.csv, line 6)",
            id="no row",
        ),
        pytest.param(
            cell(9, 0, "780.1"),
            "Time: two rows have the time 780.1 s  (a.csv, line 9)",
            id="a time twice",
        ),
        pytest.param(
            cell(9, 0, "779.5"),
            "Time: the clock jumps back: 779.5 s comes after 780.1 s  (a.csv, line 9)",
            id="clock that jumps back",
        ),
        pytest.param(
            cell(9, 0, ""),
            "Time: a row has no time  (a.csv, line 9)",
            id="no time",
        ),
        pytest.param(
            cell(12, 4, "NaN"),
            "Speed2: 'NaN' is not a number  (a.csv, line 12)",
            id="NaN",
        ),
        pytest.param(
            cell(12, 4, "fast"),
            "Speed2: 'fast' is not a number  (a.csv, line 12)",
            id="text",
        ),
        pytest.param(
            cell(12, 4, "-3"),
            "Speed2: a speed of -3 m/s; allowed: at least 0  (a.csv, line 12)",
            id="speed below zero",
        ),
        pytest.param(
            lambda text: cell(12, 13, "-0.5")(cell(13, 13, "-0.75")(text)),
            "IVS1: a gap of -0.5 m; allowed: at least 0, or --skip-negative-gaps; 1 more like it"
            "  (a.csv, line 12)",
            id="gaps below zero",
        ),
        pytest.param(
            lambda text: text.replace("CAR_C", "CAR_B"),
            "Vehicle_order: 2 cars have the name 'CAR_B'  (a.csv, line 2)",
            id="two cars of one name",
        ),
        pytest.param(
            lambda text: text.replace("CAR_C,CAR_D", "CAR_C"),
            "Vehicle_order: 3 names, and there is a column Speed4  (a.csv, line 2)",
            id="too few names",
        ),
        pytest.param(
            lambda text: text.replace("Speed3", "Speed2"),
            "'Speed2' is the name of 2 columns; allowed: of one  (a.csv, line 6)",
            id="a column twice",
        ),
        pytest.param(
            lambda text: text.replace("\n780.3,", "\n780.3\n780.35,"),
            "a row of 1 is not a row of 16, Time, Speed1, E1, N1, Speed2, E2, N2, Speed3, E3, N3, "
            "Speed4, E4, N4, IVS1, IVS2, IVS3  (a.csv, line 10)",
            id="a cut row",
        ),
        pytest.param(
            lambda text: text.replace("IVS", "JVS"),
            "no two cars follow each other for 5 s: their speeds and the gaps between them have "
            "holes of more than 1 s  (a.csv)",
            id="no gaps",
        ),
    ],
)
def test_a_bad_file_of_openacc_is_one_line(tmp_path: Path, change: Change, line: str) -> None:
    (tmp_path / "a.csv").write_text(change(OPENACC))
    outcome = zenvoy(tmp_path, "import", "openacc", "a.csv")
    assert (outcome.code, outcome.out, outcome.err) == (2, "", f"{line}\n")
    assert not (tmp_path / "a").exists()


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--cars", "CAR_X,CAR_B"), f"--cars: 'CAR_X' is not a car of a.csv; allowed: "
                                    f"{', '.join(CARS)}"),
        (("--cars", "2,2"), "--cars: a car is named twice"),
        (("--from-s", "800"), "--from-s: 800 s to 790 s has no two rows of the file, which is from "
                              "780 s to 790 s"),
        (("--to-s", "10"), "--to-s: 780 s to 10 s has no two rows of the file, which is from "
                           "780 s to 790 s"),
        (("--from-s", "787"), "no two cars follow each other for 5 s: their speeds and the gaps "
                              "between them have holes of more than 1 s  (a.csv)"),
    ],
)  # fmt: skip
def test_a_wrong_choice_is_one_line(tmp_path: Path, options: tuple[str, ...], line: str) -> None:
    (tmp_path / "a.csv").write_text(OPENACC)
    outcome = zenvoy(tmp_path, "import", "openacc", "a.csv", *options)
    assert (outcome.code, outcome.err) == (2, f"{line}\n")


@pytest.mark.parametrize(
    ("packed", "why"),
    [
        (b"no gzip", "not a gzip file"),
        (gzip.compress(OPENACC.encode())[:-200], "its end is missing"),
        (gzip.compress(OPENACC.encode())[:30] + b"\0" * 100, "not a gzip file"),
    ],
)
def test_a_damaged_gzip_file_is_one_line(tmp_path: Path, packed: bytes, why: str) -> None:
    (tmp_path / "a.csv.gz").write_bytes(packed)
    outcome = zenvoy(tmp_path, "import", "openacc", "a.csv.gz")
    assert (outcome.code, outcome.err) == (2, f"'a.csv.gz' cannot be read: {why}\n")


def test_a_folder_with_files_is_left_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(OPENACC)
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "mine.txt").write_text("mine")
    outcome = zenvoy(tmp_path, "import", "openacc", "a.csv")
    assert outcome.code == 2
    assert outcome.err == "--out a: is not empty; name a new folder or an empty one\n"
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["mine.txt"]
