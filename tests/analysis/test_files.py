"""An analysis writes tables with all digits, and files that are whole or absent."""

from __future__ import annotations

import csv
import math
import os
from pathlib import Path

import pytest

from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.page.section import Sheet


def test_a_table_keeps_all_its_digits() -> None:
    rows = ((1, 0.1 + 0.2, None, 'a "b", c'), (2, math.nan, -1e-17, "x\ny"))
    sheet = Sheet(name="s", title="S", columns=("n", "gap, m", "σ", "text"), rows=rows)
    read = list(csv.reader(csv_bytes(sheet).decode().splitlines(keepends=True)))
    assert read[0] == ["n", "gap, m", "σ", "text"]
    assert read[1] == ["1", "0.30000000000000004", "", 'a "b", c']
    assert read[2] == ["2", "nan", "-1e-17", "x\ny"]
    assert b"\r" not in csv_bytes(sheet)


def test_files_replace_older_ones(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("old")
    (tmp_path / "mine.txt").write_text("precious")
    paths = write_whole(tmp_path, {"a.csv": b"new", "b.png": b"\0"})
    assert paths == [tmp_path / "a.csv", tmp_path / "b.png"]
    left = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert left == {"a.csv": b"new", "b.png": b"\0", "mine.txt": b"precious"}


def test_no_file_is_left_if_not_all_can_be_written(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("old")
    with pytest.raises(OSError, match="too long"):
        write_whole(
            tmp_path, {"a.csv": b"new", "b" * (os.pathconf(tmp_path, "PC_NAME_MAX") + 1): b""}
        )
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a.csv": b"old"}
