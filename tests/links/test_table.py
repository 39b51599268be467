"""A loss model and a distribution of latency are one module each."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Final

import pytest

from zenvoy.keyed_random.draws import Purpose
from zenvoy.links import table
from zenvoy.links.loss import bernoulli, four_state
from zenvoy.links.table import distributions, loss_models

EVERY_NTH: Final = """
from typing import Annotated

from pydantic import Field

from zenvoy.links.loss_model import Disagreement, Effect, LossModel


def start(n, draws, size):
    return lambda rows, scene: rows.sequence % n == n - 1


def disagreements(n, key):
    if n == 13:
        yield Disagreement(key, "13 is unlucky")


LOSS = LossModel(
    key="every_nth",
    value=Annotated[int, Field(ge=2, le=1000)] | None,
    default=None,
    effect=Effect.LOSS,
    start=start,
    disagreements=disagreements,
)
"""
EXPONENTIAL: Final = """
import numpy as np

from zenvoy.links.distribution import Distribution, whole_ns


def quantile(values, technology_ms):
    return lambda draws: whole_ns(-values.mean_ms * np.log1p(-draws))


LATENCY = Distribution(name="exponential", quantile=quantile, needs=("mean_ms",))
"""
USE: Final = """
import json, sys
import zenvoy.links.latency, zenvoy.links.loss
zenvoy.links.loss.__path__.append(sys.argv[1] + "/loss")
zenvoy.links.latency.__path__.append(sys.argv[1] + "/latency")
from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.rehearsal import rehearse
from zenvoy.scenarios import ScenarioError, effective_yaml, load

def refused(*settings):
    try:
        load("quickstart", settings)
    except ScenarioError as error:
        return str(error).partition("  (")[0]

settings = ["channel.loss={p: 0, every_nth: 3}"]
settings += ["channel.latency={distribution: exponential, mean_ms: 7}"]
scenario = load("quickstart", [*settings, "duration_s=1"]).scenario
lost, latency = [], []
for frames in rehearse(scenario):
    gone = frames["outcome"] == pb.OUTCOME_LOST
    lost.append(sorted(set(gone.tolist())))
    latency += (frames["latency_ns"][~gone] / 1e6).tolist()
json.dump({
    "lost": lost,
    "mean_ms": sum(latency) / len(latency),
    "said": "every_nth: 3" in effective_yaml(scenario),
    "range": refused("channel.loss.every_nth=1"),
    "unlucky": refused("channel.loss.every_nth=13"),
    "key": refused("channel.loss.every_mth=3"),
    "name": refused("channel.latency.distribution=foo"),
    "needs": refused("channel.latency.distribution=exponential"),
    "more": refused("channel.latency={distribution: exponential, mean_ms: 1, max_ms: 2}"),
}, sys.stdout)
"""


def test_a_new_model_takes_only_a_module_of_its_own(tmp_path: Path) -> None:
    for folder, name, text in (
        ("loss", "every_nth", EVERY_NTH),
        ("latency", "exponential", EXPONENTIAL),
    ):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / f"{name}.py").write_text(text)
    command = [sys.executable, "-c", USE, str(tmp_path)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert ran.stderr == ""
    found = json.loads(ran.stdout)
    assert found.pop("lost") == [[k % 3 == 2] for k in range(10)]
    assert 7.0 < found.pop("mean_ms") < 8.0  # and a frame's time on the air
    keys = "p, path_loss, by_distance, corrupt, gilbert_elliott, four_state, every_nth"
    names = "technology, fixed, uniform, normal, gamma, pareto, samples, exponential"
    latency = "channel.latency.distribution is exponential"
    assert found == {
        "said": True,
        "range": "channel.loss.every_nth: 1 is not in [2, 1000]",
        "unlucky": "channel.loss.every_nth: 13 is unlucky",
        "key": f"channel.loss.every_mth: unknown key; did you mean 'every_nth'? allowed: {keys}",
        "name": f"channel.latency.distribution: 'foo' is not one of {names}",
        "needs": f"channel.latency.mean_ms: missing; {latency}, which needs mean_ms",
        "more": f"channel.latency.max_ms: is given, but {latency}; allowed: null",
    }


def test_draws_of_models_are_those_of_earlier_versions() -> None:
    """The same seed loses the same frames in every version."""
    numbers = {key: model.number for key, model in loss_models().items() if model.purpose}
    assert numbers == {"gilbert_elliott": 20, "four_state": 21, "path_loss": 26}


@pytest.mark.parametrize("purpose", [four_state.LOSS.purpose, Purpose.DUPLICATION])
def test_two_models_never_draw_the_same(monkeypatch: pytest.MonkeyPatch, purpose: int) -> None:
    loss_models.cache_clear()
    monkeypatch.setattr(bernoulli, "LOSS", replace(bernoulli.LOSS, purpose=purpose))
    with pytest.raises(ValueError, match=rf"has purpose {int(purpose)}, too"):
        table.loss_models()
    monkeypatch.undo()
    assert "p" in loss_models()


def test_names_have_the_order_of_messages() -> None:
    assert list(loss_models())[:2] == ["p", "path_loss"]
    assert list(distributions())[:2] == ["technology", "fixed"]
