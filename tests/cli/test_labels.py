"""Runs that are compared are named by what distinguishes them."""

from __future__ import annotations

from pathlib import Path

import pytest

from zenvoy.cli.labels import LabelError, labels_for


@pytest.mark.parametrize(
    ("logs", "names"),
    [
        (["a/x.mcap", "a/y.mcap"], ["x", "y"]),
        (["a/run.mcap", "b/run.mcap"], ["a", "b"]),
        (["p/a/run.mcap", "q/a/run.mcap"], ["p/a", "q/a"]),
        (["a/run.mcap", "a/run.mcap"], ["run 1", "run 2"]),
    ],
)
def test_runs_are_named_by_what_distinguishes_them(logs: list[str], names: list[str]) -> None:
    assert labels_for([Path(log) for log in logs], []) == names
    assert labels_for([Path(log) for log in logs], ["p", "q"]) == ["p", "q"]


@pytest.mark.parametrize(
    ("logs", "labels", "message"),
    [
        (["a.mcap"], [], "a.mcap: only one run; name two or more to compare"),
        (["a", "b"], ["x"], "--label: 1 for 2 runs; give one per run, or none"),
        (["a", "b"], ["x", "x"], "--label 'x': each run needs a name of its own"),
        (["a", "b"], ["x", " "], "--label ' ': each run needs a name of its own"),
    ],
)
def test_names_that_do_not_fit_are_refused(
    logs: list[str], labels: list[str], message: str
) -> None:
    with pytest.raises(LabelError) as refused:
        labels_for([Path(log) for log in logs], labels)
    assert str(refused.value) == message
