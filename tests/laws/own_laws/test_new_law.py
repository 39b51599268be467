"""`zenvoy new law` writes a law with its scenario and its test."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import zenvoy


def test_a_law_that_new_writes_runs_and_passes_its_test(tmp_path: Path) -> None:
    assert zenvoy(tmp_path, "new", "law", "gap_keeper").code == 0
    outcome = zenvoy(tmp_path, "check", "gap_keeper.yaml", "--strict")
    assert (outcome.code, outcome.err) == (0, "")
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_gap_keeper.py"]
    found = subprocess.run(tests, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "4 passed" in found.stdout, found.stdout
    again = zenvoy(tmp_path, "new", "law", "gap_keeper")
    assert (again.code, again.err) == (2, "gap_keeper.py: exists already\n")
    wrong = zenvoy(tmp_path, "new", "law", "gap keeper")
    assert wrong.code == 2
    assert "is not the name of a Python module" in wrong.err


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("class", "'class' is a keyword of Python; allowed: other names"),
        ("IDM", "'IDM' is a law of Zenvoy; allowed: other names than FM, BCM,"),
        ("statistics", "'statistics' is a module that is installed, which its file would hide;"),
    ],
)
def test_a_name_that_cannot_work_is_refused(tmp_path: Path, name: str, message: str) -> None:
    outcome = zenvoy(tmp_path, "new", "law", name)
    assert outcome.code == 2
    assert outcome.err.startswith(message)
    assert list(tmp_path.iterdir()) == []
