"""Each law of the library has a built-in scenario, which has the same bits on all engines."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import zenvoy
from zenvoy.analysis.log.load import load as load_log
from zenvoy.laws import builtin
from zenvoy.scenarios import builtin as scenarios
from zenvoy.scenarios import load
from zenvoy.scenarios.schema.control_laws import models_named

ENGINES: Final = ("in-process", "arrays", "processes")


def scenario_of(law: str) -> str:
    """Return the first built-in scenario with a law that all engines run; arrays run no faults."""
    loaded = ((name, load(name).scenario) for name, _ in scenarios())
    return next(name for name, one in loaded if law in models_named(one) and not one.faults)


@pytest.mark.parametrize("law", list(builtin()))
def test_a_law_has_the_same_bits_on_all_engines(tmp_path: Path, law: str) -> None:
    name = scenario_of(law)
    changes = ["--duration-s", "4"]
    for index, _ in enumerate(load(name).scenario.control.schedule):
        changes += ["--set", f"control.schedule.{index}.at_s={index + 1}"]
    prints = set()
    for engine in ENGINES:
        outcome = zenvoy(tmp_path, "run", name, *changes, "--engine", engine, "--out", engine)
        assert outcome.code == 0, outcome.err
        prints.add(json.loads((tmp_path / engine / "summary.json").read_text())["fingerprint"])
    assert len(prints) == 1
    modes = load_log(tmp_path / "arrays" / "run.mcap").estimate["mode"]
    assert builtin()[law].mode in modes
