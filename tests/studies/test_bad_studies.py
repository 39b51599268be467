"""Each bad study is refused in one line, which names the key and its place."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.studies.conftest import write_study
from zenvoy.scenarios import ScenarioError
from zenvoy.studies.sweeps.plan import MOST_RUNS
from zenvoy.studies.sweeps.study_file import read_study

AXIS = "axes: {channel.loss.p: [0, 0.5]}\n"
BAD = {
    f"scenario: quickstart\n{AXIS}mesures: [fallbacks]\n": "mesures: unknown key; did you mean "
    "'measures'? allowed: scenario, description, settings, seeds, engine, duration_s, axes, "
    "measures, series  (study.yaml, line 3)",
    AXIS: "scenario: missing; allowed: the name of a built-in scenario, or of a file beside the "
    "study  (study.yaml)",
    "scenario: quickstart\n": "axes: missing; allowed: a mapping of keys of the scenario to their "
    "values  (study.yaml)",
    f"scenario: quickstrat\n{AXIS}": "scenario: 'quickstrat' is neither a file nor a built-in",
    f"scenario: quickstart\n{AXIS}seeds: 0\n": "seeds: 0 is not a number of seeds, at least 1, or "
    "a list of whole numbers from 0 on  (study.yaml, line 3)",
    f"scenario: quickstart\n{AXIS}seeds: [1, 1]\n": "seeds.1: 1 is given twice; allowed: once  "
    "(study.yaml, line 3)",
    f"scenario: quickstart\n{AXIS}duration_s: -3\n": "duration_s: -3 is not a number in (0, 1e9]  "
    "(study.yaml, line 3)",
    f"scenario: quickstart\n{AXIS}engine: fast\n": "engine: 'fast' is not one of auto, ",
    f"scenario: quickstart\n{AXIS}measures:\n- collisions\n- smallest_gap\n": "measures.1: unknown "
    "name 'smallest_gap'; did you mean 'smallest_gap_m'? allowed: smallest_gap_m, ",
    f"scenario: quickstart\n{AXIS}series: [speed]\n": "series.0: unknown name 'speed'; ",
    f"scenario: quickstart\n{AXIS}settings: [channel.loss.p=0.1]\n": "settings: channel.loss.p is "
    "an axis of the study too  (study.yaml, line 3)",
    f"scenario: quickstart\n{AXIS}settings: [fleet.sise=3]\n": "fleet.sise: unknown key; did you "
    "mean 'size'?",
    "scenario: quickstart\naxes:\n  channel.los.p: [0.1]\n": "channel.los: unknown key; did you "
    "mean 'loss'? allowed: technology, ",
    "scenario: quickstart\naxes:\n  fleet.sise: [3]\n": "fleet.sise: unknown key; did you mean "
    "'size'?",
    "scenario: quickstart\naxes:\n  channel.loss.p: [0, 1.4]\n": "channel.loss.p: 1.4 is not in "
    "[0, 1]  (study.yaml, line 3)",
    "scenario: quickstart\naxes:\n  channel.loss.p: [0, 0]\n": "axes.channel.loss.p.values.1: 0 is "
    "given twice; allowed: once  (study.yaml, line 3)",
    "scenario: quickstart\naxes:\n  channel.loss.p: 0.3\n": "axes.channel.loss.p: 0.3 is not an "
    "axis; allowed: values, or from, to and steps, or distribution and samples, or variants  "
    "(study.yaml, line 3)",
    "scenario: quickstart\naxes:\n  channel.loss.p: {from: 0, to: 1}\n": "axes.channel.loss.p.steps"
    ": missing; allowed: a whole number of at least 2  (study.yaml, line 3)",
    "scenario: quickstart\naxes:\n  channel.loss.p: {from: 0, to: 1, stps: 3}\n": "did you mean "
    "'steps'? allowed: from, to, steps",
    "scenario: quickstart\naxes:\n  channel.loss.p: {distribution: gauss, samples: 3}\n": "axes."
    "channel.loss.p.distribution: 'gauss' is not one of uniform, normal, lognormal, choice",
    "scenario: quickstart\naxes:\n  seed: [1, 2]\n": "axes.seed: is no axis; use the key seeds of "
    "the study  (study.yaml, line 3)",
    "scenario: quickstart\naxes:\n  channel.loss.p: {from: 0, to: 1, steps: 1000000000}\n": "axes: "
    f"1,000,000,000 cells × 1 seed are 1,000,000,000 runs; allowed: at most {MOST_RUNS:,}  "
    "(study.yaml, line 2)",
    "scenario: quickstart\naxes:\n  channel.loss.p: [0]\nseeds: 1000000000\n": "1 cell × "
    "1,000,000,000 seeds are 1,000,000,000 runs",
    "scenario: quickstart\nsettings: {clock: realtime}\naxes:\n  channel.loss.p: [0]\n": "clock: "
    "realtime; a study runs as fast as it can; allowed: lock-step",
    "scenario: quickstart\naxes:\n  channel.loss.p: {distribution: uniform, low: 0, high: 1, "
    "samples: 2}\n  control.gains.k_v: {distribution: choice, values: [0.2], samples: 3}\n": "axes:"
    " random axes are drawn together, but their samples differ (channel.loss.p: 2, "
    "control.gains.k_v: 3)",
    f"scenario: quickstart\n{AXIS}engine: arrays\nmeasures: [frames.lost]\n": "measures: "
    "frames.lost: counted in a log; allowed with engine: auto or in-process  (study.yaml, line 4)",
    f"scenario: quickstart\n{AXIS}engine: arrays\nsettings: [channel.relay_hops=2]\n": "engine: "
    "channel.relay_hops: 2 does not run on arrays; allowed: 1  (study.yaml, line 3)",
    "- 3\n": "a list is not a mapping  (study.yaml)",
    "scenario: [\n": "not valid YAML: ",
}


@pytest.mark.parametrize("text", BAD, ids=range(len(BAD)))
def test_a_bad_study_is_refused_in_one_line(
    refusal_of_study: Callable[[str], list[str]], text: str
) -> None:
    lines = refusal_of_study(text)
    assert any(BAD[text] in line for line in lines), lines
    if "stps" not in text:  # there, `steps` is missing too
        assert len(lines) == 1, lines


def test_all_problems_are_reported_at_once(tmp_path: Path) -> None:
    text = "scenario: 3\naxes: {channel.loss.p: 3}\nseeds: -1\nmeasures: 7\nserie: []\n"
    with pytest.raises(ScenarioError) as refused:
        read_study(write_study(tmp_path, text))
    assert len(refused.value.problems) == 5


@settings(deadline=None)
@given(
    junk=st.recursive(
        st.none()
        | st.booleans()
        | st.integers()
        | st.floats(allow_nan=False)
        | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(["values", "variants", "from", "to", "steps", "x"]), inner
            )
        ),
        max_leaves=6,
    ),
    key=st.sampled_from(["scenario", "settings", "axes", "seeds", "measures", "series", "engine"]),
)
def test_any_value_of_a_key_is_read_or_refused_with_a_message(junk: Any, key: str) -> None:
    keys: dict[str, Any] = {"scenario": "quickstart", "axes": {"channel.loss.p": [0, 0.5]}}
    keys[key] = junk if key != "axes" else {"channel.loss.p": junk}
    problems: tuple[object, ...] = ()
    try:
        read_study(keys)
    except ScenarioError as refused:
        problems = refused.problems
    assert all("\n" not in str(problem) for problem in problems)
