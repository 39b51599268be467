"""PF-CACC: values by hand, its linear form, and delays that its prediction makes up for."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zenvoy
from zenvoy.analysis.theory.laws import is_string_stable
from zenvoy.laws import Observation, Relative, Setpoint, law_of
from zenvoy.laws.library.pf_cacc import Parameters, connected
from zenvoy.scenarios import Gains

SETPOINT: Final = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=20.0)
LENGTH_M: Final = 5.0
OWN: Final = Parameters(free_speed_mps=30.0)


def acceleration(speed: float, gap: float, relative_speed: float, own: Parameters) -> float:
    """Return the acceleration of a vehicle with a gap from bumper to bumper, m."""
    ahead = Relative(gap + LENGTH_M, relative_speed)
    return float(connected(Observation(speed, SETPOINT, ahead, length_m=LENGTH_M), own))


@pytest.mark.parametrize(
    ("speed", "gap", "relative_speed", "a"),
    [
        (18.0, 35.0, 0.0, 0.0),  # V(35 m) = 0.6 · 30 m/s
        (20.0, 35.0, 0.0, 0.4 * -2.0),
        (18.0, 35.0, 1.0, 0.5),
        (18.0, 100.0, 0.0, 0.4 * 12.0),  # V is 30 m/s at most
        (5.0, 2.0, 0.0, 0.4 * -5.0),  # and 0 at least
        (28.0, 100.0, 10.0, 0.4 * 2.0 + 0.5 * 2.0),  # a leader faster than 30 m/s counts as 30
    ],
)
def test_acceleration_by_hand(speed: float, gap: float, relative_speed: float, a: float) -> None:
    assert acceleration(speed, gap, relative_speed, OWN) == pytest.approx(a, abs=1e-12)


gains = st.floats(0.05, 2.0)


@given(gains, gains, gains)
def test_the_string_is_stable_as_the_parameters_say(
    alpha: float, beta: float, kappa: float
) -> None:
    linear = law_of("PF-CACC").linear
    assert linear is not None
    own = Parameters(alpha_per_s=alpha, beta_per_s=beta, kappa_per_s=kappa)
    _, _, k_d, k_v, k_c = linear(own, SETPOINT, 0)
    if abs(alpha + 2.0 * beta - 2.0 * kappa) > 1e-6:
        stable = is_string_stable(Gains(k_d=k_d, k_v=k_v, k_c=k_c))
        assert stable == (alpha + 2.0 * beta > 2.0 * kappa)


def test_at_its_top_speed_the_law_follows_nobody() -> None:
    linear = law_of("PF-CACC").linear
    assert linear is not None
    _, _, k_d, k_v, k_c = linear(OWN, SETPOINT._replace(v_des=30.0), 0)
    assert (k_d, k_v) == (0.0, 0.0)
    assert k_c == pytest.approx(0.4 + 0.5)


SCENARIO: Final = """
duration_s: 200
road: {type: open}
fleet: {size: 6, bumper_gap_m: %(gap)s, speed_mps: 20}
control:
  model: %(law)s
  parameters: %(parameters)s
  desired_speed_mps: 20
  gains: {k_d: 0.24, k_v: 0.5, k_c: 0.4}
  desired_bumper_gap_m: %(gap)s
  system_delay_ms: 739
sensors: {error: 0}
events: [{type: sine, vehicle: 1, at_s: 5, duration_s: 195, mean_mps: 20, amplitude_mps: 0.2,
          frequency_hz: 0.165}]
"""


def swings(folder: Path, law: str, parameters: str) -> np.ndarray:
    """Return the standard deviation of each speed, m/s, once the start is over."""
    gap = 5.0 + 20.0 / 0.6
    text = SCENARIO % {"gap": gap, "law": law, "parameters": parameters}
    (folder / "s.yaml").write_text(text)
    run = zenvoy.run(folder / "s.yaml", engine="arrays", out=folder / law)
    return np.asarray(run.truth["speed"][1000:].std(axis=0))


def test_prediction_makes_up_for_a_delay_of_0_8_s(tmp_path: Path) -> None:
    """FM with the same gains is the same law without prediction."""
    late, predicted = swings(tmp_path, "FM", "{}"), swings(tmp_path, "PF-CACC", "{}")
    assert late[-1] > 1.3 * late[0]
    assert predicted[-1] < 0.9 * predicted[0]
