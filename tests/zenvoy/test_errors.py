"""The errors of `import zenvoy` form one tree, and pass from process to process."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

import zenvoy


@pytest.mark.parametrize("name", ["frames", "busy_ratio", "summary"])
def test_a_log_that_has_gone_is_an_error_of_this_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    channel = {"technology": "ieee80211p", "medium": {"access": "csma"}}
    scenario = zenvoy.scenario("quickstart", duration_s=1, channel=channel)
    run = zenvoy.run(scenario, engine="in-process", out="o")
    again = zenvoy.load(run.log)
    run.log.unlink()
    with pytest.raises(zenvoy.LogError, match=r"^o/run\.mcap: "):
        getattr(again, name)


@pytest.mark.parametrize(
    "error",
    [
        zenvoy.ScenarioError("a"),
        zenvoy.RunError("a", Path("b")),
        zenvoy.ProcessLostError("a", Path("b"), "vehicle-1", ("c",)),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_of_a_worker_reaches_its_parent(error: zenvoy.ZenvoyError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), vars(again)) == (type(error), "a", vars(error))
