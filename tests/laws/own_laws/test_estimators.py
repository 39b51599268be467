"""An estimator of a user is found by name and checked, and runs alike everywhere."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import zenvoy
from tests.logs import write_log
from zenvoy.analysis.log.load import load

ESTIMATOR = """
from dataclasses import dataclass

import numpy as np

from zenvoy.laws import Estimator


@dataclass(frozen=True)
class Parameters:
    gain: float = 0.5
    fails_after: int = 1_000_000


class Constant:
    \"\"\"A filter with a constant gain.\"\"\"

    def __init__(self, model, z, R, own):
        self.model, self.x, self.own, self.steps = model, z, own, 0

    def step(self, inputs, z, R):
        self.steps += 1
        for a in inputs:
            self.x = self.model.F @ self.x + self.model.B[:, 0] * a
        if self.steps > self.own.fails_after:
            self.x = self.x * np.nan
        self.x = self.x + self.own.gain * (z - self.x)
        return self.x, R


constant = Estimator(name="constant", start=Constant, parameters=Parameters)
"""


def with_estimator(parameters: str) -> str:
    return f"""
duration_s: 4
fleet: {{size: 4}}
estimator: {{kind: "mine:constant", parameters: {{{parameters}}}}}
"""


def test_an_own_estimator_gives_the_same_bits_everywhere(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(ESTIMATOR)
    run = load(write_log(tmp_path / "s.mcap", with_estimator("gain: 1.0")))
    # With a gain of 1 the estimate is the reading.
    np.testing.assert_allclose(run.estimate["speed"][1:], run.radar["speed"][1:40], atol=1e-12)
    half = load(write_log(tmp_path / "h.mcap", with_estimator("gain: 0.25")))
    assert half.fingerprint != run.fingerprint
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--out", "out")
    assert outcome.code == 0, outcome.err
    assert load(tmp_path / "out" / "run.mcap").fingerprint == run.fingerprint


def test_an_estimator_that_fails_is_named(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(ESTIMATOR)
    (tmp_path / "s.yaml").write_text(with_estimator("fails_after: 10"))
    for bus in ("in-process", "zenoh"):
        outcome = zenvoy(tmp_path, "run", "s.yaml", "--bus", bus, "--out", bus)
        assert outcome.code == 3
        first = outcome.err.splitlines()[0]
        assert "died: estimator constant returned (array([nan" in first
        assert first.endswith(", which is no state (2,) with its covariance (2, 2) (mine.py)")


@pytest.mark.parametrize(
    ("estimator", "message"),
    [
        (
            'kind: "mine:other"',
            "estimator.kind: 'mine:other': mine.py has no other; allowed: constant  (s.yaml, ",
        ),
        (
            'kind: "idm:smith"',
            "estimator.kind: 'idm:smith': idm.py has a value that is not of type Estim",
        ),
        (
            "kind: kf",
            "estimator.kind: 'kf' is not one of kalman, ekf, ukf, or file:NAME such as "
            "constant:CONSTANT",
        ),
        (
            "kind: ekf, parameters: {gain: 1}",
            "estimator.parameters: given, but the built-in estimators have none",
        ),
        (
            'kind: "mine:constant", parameters: {gain: high}',
            "estimator.parameters.gain: 'high' is not a number",
        ),
    ],
)
def test_a_wrong_estimator_is_refused_with_a_message(
    laws: Path, estimator: str, message: str
) -> None:
    (laws / "mine.py").write_text(ESTIMATOR)
    (laws / "s.yaml").write_text(f"estimator: {{{estimator}}}")
    outcome = zenvoy(laws, "check", "s.yaml")
    assert outcome.code == 2
    assert outcome.err.startswith(message)
