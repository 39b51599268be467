"""Strings of vehicles that keep a time headway move as linear theory predicts."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import pytest

import zenvoy
from zenvoy.analysis.log.load import load
from zenvoy.analysis.measures.stability import response
from zenvoy.analysis.theory.disturbed import Disturbed, disturbed
from zenvoy.analysis.theory.laws import transfer
from zenvoy.laws.library import idm

SPEED_MPS: Final = 20.0
# A command takes effect 1 ms after the readings that it is based on.
SCENARIO: Final = """
duration_s: 200
period_ms: 40
road: {{type: open}}
fleet: {{size: 6, bumper_gap_m: {gap_m}, speed_mps: 20}}
control:
  model: {model}
  parameters: {parameters}
  desired_speed_mps: 20
  v2v_wait_ms: 1
  system_delay_ms: 0
sensors: {{error: 0}}
events: [{event}]
"""
# It ends after 4.5 oscillations, at the speed at which it began.
CHIRP: Final = """{type: sine, vehicle: 1, at_s: 5, duration_s: 60, mean_mps: 20,
                   amplitude_mps: 0.2, frequency_hz: 0.01, to_frequency_hz: 0.14}"""
BRAKE: Final = "{type: brake, vehicle: 1, at_s: 5, duration_s: 1, deceleration_mps2: 0.05}"


def ran(folder: Path, model: str, parameters: str, gap_m: float, event: str) -> Disturbed:
    (folder / "s.yaml").write_text(
        SCENARIO.format(model=model, parameters=parameters, gap_m=gap_m, event=event)
    )
    run = zenvoy.run(folder / "s.yaml", engine="arrays", out=folder / "run")
    case = disturbed(load(run.log))
    assert isinstance(case, Disturbed), case
    assert case.noise < 1e-3
    return case


@pytest.mark.parametrize(
    ("model", "parameters", "gap_m"),
    [
        ("ACC", "{headway_s: 0.8, lambda_per_s: 0.4}", 18.0),
        ("ACC", "{}", 26.0),
        ("IDM", "{}", idm.equilibrium_gap_m(idm.Parameters(), SPEED_MPS)),
    ],
)
def test_a_string_moves_as_theory_says(
    tmp_path: Path, model: str, parameters: str, gap_m: float
) -> None:
    """From the motion of the first vehicle, theory predicts the speeds of all others."""
    case = ran(tmp_path, model, parameters, gap_m, CHIRP)
    assert case.predicted is not None
    largest = np.abs(case.deviation[:, case.source]).max()
    assert np.abs(case.deviation[:, 1:]).max() > 0.3 * largest
    assert np.abs(case.predicted - case.deviation).max() < 0.02 * largest


@pytest.mark.parametrize("share", [0.3, 1.5])
def test_drivers_amplify_below_their_limit_and_not_above(tmp_path: Path, share: float) -> None:
    own = idm.Parameters()
    a = share * idm.stable_acceleration_mps2(own, SPEED_MPS)
    gap_m = idm.equilibrium_gap_m(own, SPEED_MPS)
    case = ran(tmp_path, "IDM", f"{{acceleration_mps2: {a}}}", gap_m, BRAKE)
    first, last = case.deviation[:, 0], case.deviation[:, -1]
    found = response(np.gradient(first), np.gradient(last), case.period_s, 0.05)
    gain = np.abs(found.ratio) ** 0.2  # of each of five vehicles
    assert case.theory is not None
    _, gains, delay_s, _ = case.theory.members[1]
    theory = np.abs(transfer(found.omega, gains, delay_s))
    seen = theory > 0.6  # for five vehicles that is a thirteenth
    np.testing.assert_allclose(gain[seen], theory[seen], rtol=0.02)
    assert (gain.max() > 1.02, gain.max() < 1.0) == (share < 1.0, share > 1.0)
