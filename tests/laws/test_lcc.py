"""LCC: values by hand, its equilibrium, and the head-to-tail response that its paper derives."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import pytest

import zenvoy
from zenvoy.analysis.measures.stability import response
from zenvoy.laws import Observation, Relative, Setpoint, law_of
from zenvoy.laws.library import idm, lcc

SETPOINT: Final = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=20.0, v_des=15.0)
REST: Final = (
    (Relative(20.0, 0.0), Relative(20.0, 0.0)),
    (Relative(40.0, 0.0), Relative(40.0, 0.0)),
)
OWN: Final = lcc.Parameters(alpha_1=1.0, alpha_2=1.5, alpha_3=0.9)


def acceleration(
    speed: float, *sides: tuple[Relative, Relative], own: lcc.Parameters = OWN
) -> float:
    ahead = sides[0][0]
    return float(lcc.leading(Observation(speed, SETPOINT, ahead, sides=sides), own))


@pytest.mark.parametrize(
    ("speed", "sides", "a"),
    [
        (15.0, REST, 0.0),
        # The own gap is 1 m too wide; so is that of the vehicle ahead, 1 m narrower.
        (15.0, ((Relative(21.0, 0.0), REST[0][1]), REST[1]), 1.0 - 1.0),
        # The host is 2 m/s too fast: -1.5 · 2 + 0.9 · 0 for a steady vehicle ahead, and the others
        # drive at 15 m/s, so their speeds do not count.
        (
            17.0,
            (
                (Relative(20.0, -2.0), Relative(20.0, 2.0)),
                (Relative(40.0, -2.0), Relative(40.0, 2.0)),
            ),
            -3.0,
        ),
        # The first follower falls 3 m behind, and the second one with it.
        (15.0, ((REST[0][0], Relative(23.0, 0.0)), (REST[1][0], Relative(43.0, 0.0))), -3.0),
        # The second follower drives 0.5 m/s slower.
        (15.0, (REST[0], (REST[1][0], Relative(40.0, 0.5))), 0.5),
        # Only one vehicle is known on each side.
        (15.0, ((Relative(20.0, 1.0), Relative(22.0, 0.0)),), 0.9 - 2.0),
    ],
)
def test_acceleration_by_hand(
    speed: float, sides: tuple[tuple[Relative, Relative], ...], a: float
) -> None:
    assert acceleration(speed, *sides) == pytest.approx(a, abs=1e-12)


def test_the_gains_of_the_own_dynamics_are_those_of_the_paper() -> None:
    """The optimal velocity model with α = 0.6, β = 0.9, v_max = 30 m/s, from 5 to 35 m, at 20 m."""
    alpha_1 = 0.6 * 30.0 / 2.0 * np.pi / 30.0 * np.sin(np.pi / 2.0)
    own = lcc.Parameters()
    assert (own.alpha_1, own.alpha_2, own.alpha_3) == pytest.approx(
        (alpha_1, 0.6 + 0.9, 0.9), abs=1e-3
    )


# --- one LCC between human drivers: 1 is the head, 3 the LCC, 4 and 5 follow ---------------------

SCENARIO: Final = """
duration_s: 240
period_ms: 20
road: {type: open}
fleet:
  size: 5
  speed_mps: 15
  bumper_gap_m: %s
  groups: [{name: leading, vehicles: 3, model: %s, parameters: %s}]
control:
  model: IDM
  desired_bumper_gap_m: %s
  desired_speed_mps: 15
  v2v_wait_ms: 11
  system_delay_ms: 0
sensors: {error: 0}
events: [{type: brake, vehicle: 1, at_s: 5, duration_s: 1, deceleration_mps2: 0.05}]
"""


def head_to_tail(folder: Path, law: str, parameters: str) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (rad/s), and the gain of speed from the head to the last vehicle."""
    gap = idm.equilibrium_gap_m(idm.Parameters(), 15.0)
    (folder / "s.yaml").write_text(SCENARIO % (gap, law, parameters, gap))
    run = zenvoy.run(folder / "s.yaml", engine="arrays", out=folder / "run")
    speed = run.truth["speed"]
    found = response(np.gradient(speed[:, 0]), np.gradient(speed[:, -1]), 0.02, 0.05)
    slow = found.omega < 0.8
    return found.omega[slow], np.abs(found.ratio[slow])


def test_the_response_is_that_of_the_paper(tmp_path: Path) -> None:
    """Section IV, for vehicle -1 ahead and 1 and 2 behind; the drivers are IDM, linearised."""
    linear = law_of("IDM").linear
    assert linear is not None
    _, _, k_d, k_v, k_c = linear(idm.Parameters(), SETPOINT._replace(v_des=15.0), 0)
    own = lcc.Parameters(alpha_1=0.3, mu_ahead=0.1, k_ahead=-0.2, mu_behind=-0.1, k_behind=-0.2)
    text = f"{{alpha_1: {own.alpha_1}, mu_ahead: {own.mu_ahead}, k_ahead: {own.k_ahead}, "
    text += f"mu_behind: {own.mu_behind}, k_behind: {own.k_behind}}}"
    omega, gain = head_to_tail(tmp_path, "LCC", text)
    s = 1j * omega
    late = np.exp(-s * 0.021)  # the wait, and half a period
    g = (k_v * s + k_d) * late / (s * s + ((k_v + k_c) * s + k_d) * late)
    # ṽ_(-1) = g ṽ_(-2), s_(-1) = (ṽ_(-2) - ṽ_(-1)) / s, and so on, relative to the host.
    ahead = own.alpha_1 / s + own.alpha_3 + own.mu_ahead * (1.0 / g - 1.0) / s + own.k_ahead
    behind = sum(own.mu_behind * (g ** (j - 1) - g**j) / s + own.k_behind * g**j for j in (1, 2))
    host = ahead * late / (s + (own.alpha_1 / s + own.alpha_2 - behind) * late)
    theory = np.abs(g * host * g * g)
    assert np.abs(g).max() > 1.005  # the drivers amplify
    np.testing.assert_allclose(gain, theory, rtol=0.02, atol=2e-3)
