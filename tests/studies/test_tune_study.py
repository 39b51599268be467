"""Studies for `zenvoy tune`: what is read of them, and the line that each bad one gets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import zenvoy
from zenvoy.scenarios import ScenarioError
from zenvoy.studies.tuning.best import best_yaml
from zenvoy.studies.tuning.folder import held
from zenvoy.studies.tuning.parameters import Span
from zenvoy.studies.tuning.reading import read_tune_study
from zenvoy.studies.tuning.search import proposal
from zenvoy.studies.tuning.study import Constraint
from zenvoy.studies.tuning.trial import Trial, ranked
from zenvoy.studies.tuning.tune import run_tune

GOOD = """
scenario: quickstart
settings: {fleet.size: 6, road.type: open, control.model: FM}
duration_s: 2
parameters:
  control.gains.k_v: {low: 0.1, high: 1}
minimize: gap.measured.rmse
"""
PARAMETER = "control.gains.k_v: {low: 0.1, high: 1}"


def with_parameter(text: str) -> str:
    assert PARAMETER in GOOD
    return GOOD.replace(PARAMETER, text)


BAD = {
    "trials: 3": "scenario: missing; allowed: the name of a built-in scenario",
    "scenario: quickstart\nminimize: collisions": "parameters: missing; allowed: one key of",
    "scenario: quickstart\nminimize: collisions\nparameters: {}": "parameters: a mapping is not",
    GOOD.replace("minimize: gap.measured.rmse", ""): "minimize: missing; allowed: a measure, also",
    GOOD
    + "maximize: collisions": "maximize: 'collisions' beside minimize; allowed: one of the two",
    GOOD.replace("gap.measured.rmse", "gap.rmse"): "minimize: unknown name 'gap.rmse'; ",
    GOOD + "constraints: {colisions: {max: 0}}": "did you mean 'collisions'?",
    GOOD + "constraints: {collisions: 0}": "constraints.collisions: 0 is no limit; allowed: max,",
    GOOD + "constraints: {collisions: {}}": "constraints.collisions: has no limit; allowed: max,",
    GOOD + "constraints: {collisions: {most: 0}}": "constraints.collisions.most: unknown key; ",
    GOOD + "constraints: {collisions: {max: a}}": "constraints.collisions.max: 'a' is not a number",
    GOOD + "constraints: {collisions: {max: 0, min: 1}}": "max 0 is below min 1",
    GOOD + "constraints: [collisions]": "constraints: a list is not a mapping of measures",
    GOOD + "trials: 0": "trials: 0 is not a whole number in [1, 10000]  (study.yaml, line 8)",
    GOOD + "trials: 1.5": "trials: 1.5 is not a whole number",
    GOOD
    + "trials: 1000\nseeds: 200": "1,000 trials × 200 seeds are 200,000 runs; allowed: at most",
    GOOD + "sampler: tpe": "sampler: 'tpe' is not a mapping of kind, seed and startup",
    GOOD + "sampler: {kind: grid}": "sampler.kind: 'grid' is not one of tpe, random",
    GOOD + "sampler: {seed: -1}": "sampler.seed: -1 is not a whole number in [0, 2^63)",
    GOOD + "seeds: [1, 1]": "seeds.1: 1 is given twice; allowed: once",
    GOOD + "axes: {}": "axes: unknown key; allowed: scenario, description, settings, parameters,",
    GOOD + "engine: zenoh": "engine: 'zenoh' is not one of auto, arrays, in-process",
    GOOD.replace("gap.measured.rmse", "frames.lost")
    + "engine: arrays": "engine: arrays; frames.lost",
    with_parameter("control.gains.k_x: {low: 0, high: 1}"): "control.gains.k_x: unknown key; ",
    with_parameter("control.gains.k_v: {low: 1, high: 1}"): "k_v.low: 1 is not below high, 1  (",
    with_parameter("control.gains.k_v: {low: 2, high: 1}"): "k_v.low: 2 is not below high, 1",
    with_parameter("control.gains.k_v: {low: a, high: 1}"): "k_v.low: 'a' is not a number in",
    with_parameter(
        "control.gains.k_v: {low: 1}"
    ): "control.gains.k_v.high: missing; allowed: a num",
    with_parameter("control.gains.k_v: {low: -1, high: 1}"): "control.gains.k_v: -1.0 is not in",
    with_parameter("control.gains.k_v: {low: 0, high: 1, log: true}"): "k_v.low: 0 is not above 0;",
    with_parameter("control.gains.k_v: {low: 0, high: 1, step: 0.3}"): "0.3 does not lead from 0",
    with_parameter("control.gains.k_v: {low: 1, high: 2, step: 0.5, log: true}"): "with log: true",
    with_parameter(
        "control.gains.k_v: {low: 0, high: 1, stp: 1}"
    ): "stp: unknown key; did you mean",
    with_parameter("control.gains.k_v: 0.5"): "0.5 is no parameter; allowed: low and high, or choi",
    with_parameter("control.gains.k_v: {choices: [0.5]}"): "is not a list of two values or more",
    with_parameter("control.gains.k_v: {choices: [1, 2, 1]}"): "choices.2: 1 is given twice",
    with_parameter("control.model: {choices: [FM, GM]}"): "settings: control.model is a parameter",
    with_parameter("fleet.speed_mps: {choices: [20, fast]}"): "fleet.speed_mps: 'fast' is not",
    with_parameter(
        "seed: {low: 1, high: 9}"
    ): "parameters.seed: is no parameter; use the key seeds",
    GOOD.replace("open", "ring")
    + "constraints: {head_to_tail_gain: {max: 1}}": "a ring has no head",
    GOOD.replace("FM", "CACC") + "constraints: {head_to_tail_gain: {max: 1}}": "no linear form",
    GOOD.replace("quickstart", "quikstart"): "did you mean 'quickstart'?",
    GOOD.replace("duration_s: 2", "clock: realtime"): "clock: unknown key",
    GOOD.replace("{fleet.size: 6,", "{clock: realtime,"): "clock: realtime; a study runs as fast",
}


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_a_bad_study_gets_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.yaml").write_text(text)
    with pytest.raises(ScenarioError) as refused:
        run_tune("study.yaml", out=tmp_path / "o", jobs=1, on_line=print, command="c")
    lines = str(refused.value).splitlines()
    assert any(BAD[text] in line for line in lines), lines
    assert not (tmp_path / "o").exists()


def test_the_command_prints_it_and_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(GOOD + "trials: 0\n")
    outcome = zenvoy(tmp_path, "tune", "study.yaml", "--out", "out")
    assert outcome.code == 2
    assert outcome.err == ("trials: 0 is not a whole number in [1, 10000]  (study.yaml, line 8)\n")
    assert outcome.out == ""
    assert not (tmp_path / "out").exists()


# Parameters.


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


# Constraints and ranks.


def test_the_worst_seed_decides() -> None:
    most = Constraint(figure="collisions", bound="max", limit=1)
    assert (most.worst((0.0, 2.0)), most.excess((0.0, 2.0))) == (2.0, 1.0)
    least = Constraint(figure="smallest_gap_m", bound="min", limit=5)
    assert (least.worst((7.0, 4.0)), least.excess((7.0, 4.0))) == (4.0, 1.0)
    assert least.excess((7.0, 5.0)) == 0.0
    assert (str(most), str(least)) == ("collisions ≤ 1", "smallest_gap_m ≥ 5")


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


def test_a_search_in_theory_alone_runs_nothing(tmp_path: Path) -> None:
    keys = {
        "scenario": "quickstart",
        "settings": {"road.type": "open", "control.model": "FM", "fleet.size": 5},
        "parameters": {"control.gains.k_v": {"low": 0.1, "high": 3}},
        "minimize": "head_to_tail_gain",
        "trials": 8,
    }
    done = run_tune(keys, out=tmp_path / "o", jobs=1, on_line=lambda _: None, command="c")
    gains = [trial.figures["head_to_tail_gain"][0] for trial in done.trials]
    assert done.best is not None
    assert done.best.objective(done.study) == min(gains)
    assert list((tmp_path / "o" / "runs").iterdir()) == []


@pytest.mark.parametrize("name", ["a?b=c#d", "100 % {x}", "Zügé"])
def test_a_folder_may_have_any_name(tmp_path: Path, name: str) -> None:
    keys = {**KEYS, "minimize": "head_to_tail_gain", "trials": 1}
    keys |= {"settings": {"road.type": "open"}}
    for line in ("1 trial × 1 seed, 1 to do", "1 trial × 1 seed, 0 to do"):
        told: list[str] = []
        run_tune(keys, out=tmp_path / name, jobs=1, on_line=told.append, command="c")
        assert told[0] == line
    assert (tmp_path / name / "trials.db").is_file()
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_folder_is_for_one_search_at_a_time(tmp_path: Path) -> None:
    refused = pytest.raises(ScenarioError, match="another zenvoy tune is at work")
    with held(tmp_path), refused, held(tmp_path):
        pass
    with held(tmp_path):  # the end of the other one has freed it
        pass


# The best trial as a scenario.


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
