"""Studies for `zenvoy tune` are read, and each bad one is refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import zenvoy
from zenvoy.scenarios import ScenarioError
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
    GOOD + "axes: {}": "axes: unknown key; allowed: scenario, description, settings, seeds,",
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
