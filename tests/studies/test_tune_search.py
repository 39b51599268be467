"""The search proposes values, ranks its trials, and writes the best one as a scenario."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.scenarios import load
from zenvoy.studies.tuning.best import best_yaml, cell_of
from zenvoy.studies.tuning.parameters import Span
from zenvoy.studies.tuning.reading import read_tune_study
from zenvoy.studies.tuning.search import proposal
from zenvoy.studies.tuning.trial import Trial, ranked

KEYS: dict[str, Any] = {
    "scenario": "quickstart",
    "parameters": {
        "control.gains.k_v": {"low": 0.1, "high": 1.0},
        "control.gains.k_c": {"low": 0.01, "high": 1.0, "log": True},
        "fleet.size": {"low": 5, "high": 25, "step": 5},
        "control.model": {"choices": ["FM", "BCM", "PBCM"]},
    },
    "minimize": "gap.measured.rmse",
}


@given(low=st.floats(-1e6, 1e6), width=st.floats(1e-3, 1e6), share=st.floats(0, 1))
def test_a_value_stays_inside_and_can_be_typed(low: float, width: float, share: float) -> None:
    span = Span(low=low, high=low + width)
    value = span.value_of(min(low + share * width, low + width))
    assert low <= value <= low + width
    assert value in {low, low + width} or float(f"{value:.6g}") == value


def test_whole_numbers_need_a_whole_step() -> None:
    assert Span(low=2, high=10, step=2).whole
    assert not Span(low=0, high=1).whole  # a fraction, as of frames that are lost
    assert not Span(low=0, high=1, step=0.5).whole
    assert isinstance(Span(low=2, high=10, step=2).value_of(4), int)
    assert Span(low=0, high=1, step=0.1).value_of(0.1 * 3) == 0.3  # and no 0.30000000000000004


@pytest.mark.parametrize("kind", ["tpe", "random"])
def test_proposals_are_of_their_ranges(kind: str) -> None:
    study = read_tune_study({**KEYS, "sampler": {"kind": kind, "startup": 3}})
    trials: list[Trial] = []
    for number in range(1, 12):
        point = proposal(study, trials)
        assert 0.1 <= point["control.gains.k_v"] <= 1.0
        assert 0.01 <= point["control.gains.k_c"] <= 1.0
        assert point["fleet.size"] in {5, 10, 15, 20, 25}
        assert isinstance(point["fleet.size"], int)
        assert point["control.model"] in {"FM", "BCM", "PBCM"}
        value = (point["control.gains.k_v"] - 0.4) ** 2
        figures = {"gap.measured.rmse": (value,)}
        trials.append(Trial(number=number, point=point, figures=figures))
    assert len({json.dumps(trial.point) for trial in trials}) == len(trials)


def test_a_proposal_depends_on_the_trials_and_the_seed_alone() -> None:
    """So a search that was stopped goes on as if it had not been."""
    study = read_tune_study({**KEYS, "sampler": {"startup": 2}})
    figures = {"gap.measured.rmse": (1.0,)}
    first = Trial(number=1, point=proposal(study, []), figures=figures)
    second = Trial(number=2, point=proposal(study, [first]), figures=figures)
    third = Trial(number=3, point=proposal(study, [first, second]), figures={}, failure="why")
    assert proposal(study, [first, second, third]) == proposal(study, [first, second, third])
    other = read_tune_study({**KEYS, "sampler": {"startup": 2, "seed": 2}})
    assert proposal(other, [first, second, third]) != proposal(study, [first, second, third])


@settings(max_examples=20)
@given(seed=st.integers(0, 2**63 - 1))
def test_first_trials_spread_over_the_range(seed: int) -> None:
    keys = {**KEYS, "parameters": {"control.gains.k_v": {"low": 0, "high": 1}}}
    study = read_tune_study({**keys, "sampler": {"kind": "random", "seed": seed}})
    done = [Trial(number=n, point={"control.gains.k_v": 0.5}, figures={}) for n in range(1, 30)]
    values = [proposal(study, done[:n])["control.gains.k_v"] for n in range(30)]
    assert min(values) < 0.4
    assert max(values) > 0.6


@pytest.mark.parametrize(("direction", "order"), [("minimize", [2, 4, 3]), ("maximize", [3, 2, 4])])
def test_feasible_trials_are_ranked(direction: str, order: list[int]) -> None:
    keys = {key: value for key, value in KEYS.items() if key != "minimize"}
    keys |= {direction: "gap.measured.rmse", "constraints": {"collisions": {"max": 0}}}
    study = read_tune_study(keys)
    point = proposal(study, [])
    values = {1: (0.5, 1), 2: (1.0, 0), 3: (2.0, 0), 4: (1.0, 0)}
    trials = [
        Trial(
            number=number,
            point=point,
            figures={"gap.measured.rmse": (rmse,), "collisions": (float(collisions),)},
        )
        for number, (rmse, collisions) in values.items()
    ]
    trials.append(Trial(number=5, point=point, figures={}, failure="why"))
    assert [trial.number for trial in ranked(study, trials)] == order


@pytest.mark.parametrize(
    "changes",
    [
        {"fleet.size": 8},
        {"fleet": {"size": 8}, "channel": {"loss": {"p": 0.2}}},
        ["fleet.size=8", "events.0.duration_s=1.5"],
        {"events": []},
        ["events=[]", "channel.technology=5g-mmwave"],
    ],
    ids=range(5),
)
def test_the_best_scenario_is_that_of_the_trial(tmp_path: Path, changes: Any) -> None:
    keys: dict[str, Any] = {
        "scenario": "quickstart",
        "settings": changes,
        "duration_s": 3,
        "seeds": [7],
        "minimize": "gap.measured.rmse",
        "parameters": {
            "control.gains.k_v": {"low": 0.1, "high": 1},
            "sensors.error": {"choices": [0, 0.1]},
        },
    }
    study = read_tune_study(keys)
    trial = Trial(number=1, point=proposal(study, []), figures={"gap.measured.rmse": (1.0,)})
    text = best_yaml(study, trial, tmp_path)
    assert text is not None
    assert b"\nextends: quickstart\n" in text
    (tmp_path / "best.yaml").write_bytes(text)
    assert load(tmp_path / "best.yaml").scenario == cell_of(study, trial).load().scenario
