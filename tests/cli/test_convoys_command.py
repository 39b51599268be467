"""`zenvoy convoys` makes a page from recordings, and refuses in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.recorded_convoys import openacc_text, platoon


def test_a_page_is_made_of_a_recording(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(openacc_text(platoon(8.0)))
    done = zenvoy(tmp_path, "convoys", "a.csv", "--law", "fm", "--seeds", "1", "--out", "p/real")
    assert (done.code, done.err) == (0, "")
    page = (tmp_path / "p" / "real.md").read_text()
    assert "zenvoy convoys a.csv --seeds 1 --law fm --out p/real" in page
    assert "Recorded, ACC, short setting: the swing grows" in page
    names = {path.name for path in (tmp_path / "p" / "real").iterdir()}
    assert {"one-run.png", "growth.svg", "shares-begun-beacons.csv", "fits.csv"} <= names
    assert done.out.splitlines()[-1] == "p/real.md"


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("a.csv", "a.csv"), "a: 2 recordings have this name; allowed: one"),
        (("b.csv",), "'b.csv' cannot be read: No such file or directory"),
        (("a.csv", "--law", "no.py:X"), "--law: 'no.py:X': there is no file no.py"),
    ],
)
def test_wrong_input_is_one_line(tmp_path: Path, options: tuple[str, ...], line: str) -> None:
    (tmp_path / "a.csv").write_text(openacc_text(platoon(8.0)))
    done = zenvoy(tmp_path, "convoys", *options)
    assert (done.code, done.err) == (2, f"{line}\n")
