"""A process reports each kind and source of refused messages once, and counts at its end."""

from __future__ import annotations

import pytest

from tests.fleet_of_three import MOST_LINES
from zenvoy.bus.refusals import Refusals


def test_each_kind_and_source_is_reported_once(capsys: pytest.CaptureFixture[str]) -> None:
    refusals = Refusals("world")
    for _ in range(3):
        refusals.add("stale", "a/b")
        refusals.add("early", "a/b")
        refusals.add("stale", "a/\nworld: all is well")
    refusals.add("early", "a/b", 40)  # a bundle
    refusals.report_counts()
    assert capsys.readouterr().err.splitlines() == [
        "world: refused: stale, on 'a/b'",
        "world: refused: early, on 'a/b'",
        r"world: refused: stale, on 'a/\nworld: all is well'",
        "world: messages refused: 43 early, 6 stale",
    ]


def test_the_report_of_refusals_is_bounded(capsys: pytest.CaptureFixture[str]) -> None:
    refusals = Refusals("world")
    for number in range(1_000):
        refusals.add("foreign", f"{number}/" + 1_000 * "x")
    refusals.report_counts()
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == MOST_LINES
    assert max(map(len, lines)) < 200
    assert lines[-1] == "world: messages refused: 1000 foreign"


def test_nothing_is_reported_if_nothing_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Refusals("world").report_counts()
    assert capsys.readouterr().err == ""
