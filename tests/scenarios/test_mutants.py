"""A sample of `make mutants`: randomly changed scenarios are refused with a message, or run."""

from __future__ import annotations

from pathlib import Path

from tests.mutants import main


def test_mutants_are_refused_or_run(tmp_path: Path) -> None:
    fates = main(60, 0, tmp_path)
    assert fates.keys() <= {"refused", "ran", "accepted, too large to run"}
    assert fates["refused"] > 20
    assert fates["ran"] > 5
