"""Runs on arrays have the values of a log of the in-process bus, bit for bit."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fleet.test_arrays import of_seeds
from tests.fleet.whole_scenarios import whole_scenarios
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.log.load import load as load_log
from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.measures.digest import Digest, digest
from zenvoy.analysis.measures.summary import summary_of
from zenvoy.bus.topics import ESTIMATE, RADAR, TRUTH
from zenvoy.fleet.arrays.columns import columns_of
from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.fleet.folder import LOG, make_folder
from zenvoy.fleet.run import run
from zenvoy.scenarios import Loaded, Scenario, load
from zenvoy.studies.batches import Wanted, bytes_of_run, run_batch

EXAMPLES: Final = int(os.environ.get("ARRAY_EXAMPLES", "15"))


def everything(*runs: Loaded) -> Wanted:
    """Return all columns that any of these runs has."""
    found: dict[str, dict[str, None]] = {}
    for one in runs:
        for topic, names in columns_of(one.scenario).items():
            found.setdefault(topic, {}).update(dict.fromkeys(names))
    return {topic: list(names) for topic, names in found.items()}


def logged(loaded: Loaded) -> Run:
    """Return the same run on the in-process bus, from its log."""
    with tempfile.TemporaryDirectory() as folder:
        made = make_folder(Path(folder) / "run", loaded.name)
        assert run(loaded, made, "in-process") is None
        return load_log(made / LOG)


def differences(found: Run, expected: Run) -> list[str]:
    """Return what differs between two runs, except for what only a log has."""
    wrong = []
    for topic in columns_of(found.scenario):
        table, other = found[topic], expected[topic]
        missing = {name for name in other if name not in table and other[name].size}
        wrong += [f"{topic}: {name}" for name in missing]
        for name, column in table.items():
            same = column.dtype == other[name].dtype and column.shape == other[name].shape
            if not same or column.tobytes() != other[name].tobytes():
                wrong.append(f"{topic}: {name}")
    for name in ("events", "notes", "name", "seed", "scenario", "units", "cycles"):
        if getattr(found, name) != getattr(expected, name):
            wrong.append(name)
    for key in ("end", "cycles", "simulated_s"):
        if found.result[key] != expected.result[key]:
            wrong.append(f"result: {key}")
    return wrong


def as_values(found: Digest) -> tuple[object, ...]:
    """Return what a digest holds, except for fingerprint and wall time."""
    facts = {name: v for name, v in found.facts.items() if name not in {"fingerprint", "wall_s"}}
    names = (name for name in Digest.__slots__ if name != "facts")
    return (repr(facts), *(getattr(found, name).tobytes() for name in names))


BUILT_IN: Final = {
    "ring": ("paper/case-15", ()),
    "open road": ("paper/case-11", ("road.type=open",)),
    "fallbacks": ("heavy-loss", ()),
    "platoons": ("mixed/platoons", ()),
    "a law of its own": ("mixed/humans", ()),
    "an event of each kind": ("manoeuvres/open-gap", ()),
    "stopped by a collision": ("paper/case-01", ("on_collision=stop", "control.gains.k_d=3")),
}


@pytest.mark.parametrize(("name", "changes"), BUILT_IN.values(), ids=BUILT_IN)
def test_values_are_those_of_the_log(name: str, changes: Sequence[str]) -> None:
    runs = [load(name, changes, seed=seed, duration_s=15.0) for seed in (4, 9)]
    found = list(run_batch(runs, everything(*runs)))
    for loaded, one in zip(runs, found, strict=True):
        expected = logged(loaded)
        assert differences(one, expected) == []
        assert as_values(digest(one)) == as_values(digest(expected))


@given(whole_scenarios(), st.integers(0, 2**63 - 1))
@settings(max_examples=EXAMPLES)
def test_values_of_any_scenario_are_those_of_the_log(scenario: Scenario, other_seed: int) -> None:
    if uncovered(scenario):
        return
    runs = [
        Loaded(name="drawn", scenario=one, text="")
        for one in of_seeds(scenario, other_seed, scenario.seed)
    ]
    *_, found = run_batch(runs, everything(*runs))
    assert differences(found, logged(runs[1])) == []


def test_only_wanted_columns_are_kept() -> None:
    runs = [load("paper/case-15", duration_s=2.0)]
    (found,) = run_batch(runs, {TRUTH.log_name: ["speed"], ESTIMATE.log_name: ["ahead_gap"]})
    assert set(found.truth) == {"cycle", "time_ns", "speed"}
    assert set(found.radar) == {"cycle", "time_ns"}
    assert set(found.estimate) == {"cycle", "time_ns", "ahead_gap"}
    expected = logged(runs[0])
    assert np.array_equal(found.estimate["ahead_gap"], expected.estimate["ahead_gap"], True)


def test_runs_are_split_if_they_would_take_too_much_memory() -> None:
    runs = [load("paper/case-15", seed=seed, duration_s=1.0) for seed in range(5)]
    wanted = {TRUTH.log_name: ["position"]}
    limit = 2 * bytes_of_run(runs[0].scenario, wanted)
    split = list(run_batch(runs, wanted, limit_bytes=limit))
    at_once = list(run_batch(runs, wanted))
    assert [run.seed for run in split] == [0, 1, 2, 3, 4]
    assert len({id(run.truth["position"].base) for run in split}) == 3  # 1, 2 and 2 runs
    for one, other in zip(split, at_once, strict=True):
        assert np.array_equal(one.truth["position"], other.truth["position"])


def test_a_run_without_a_log_has_neither_fingerprint_nor_frames() -> None:
    loaded = load("paper/case-15", duration_s=1.0)
    (found,) = run_batch([loaded], everything(loaded))
    assert found.fingerprint is None
    with pytest.raises(LogError, match="paper/case-15, seed 1: was not logged; its frames need"):
        _ = found.frames
    summary = summary_of(found)
    assert (summary["frames"], summary["wall_s"], summary["bus"]) == (None, None, "arrays")


def test_a_missing_column_is_named() -> None:
    loaded = load("paper/case-15", duration_s=1.0)
    with pytest.raises(ValueError, match="/fleet/radar: these runs have no column heat"):
        next(run_batch([loaded], {RADAR.log_name: ["heat"]}))
