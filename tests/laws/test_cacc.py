"""CACC matches values computed by hand."""

from __future__ import annotations

import pytest

from tests.laws.by_hand import REST, WANTED
from zenvoy.laws import Motion, Observation, Relative
from zenvoy.laws.library import cacc

STEADY = Motion(30.0, 0.0)


def cooperative(
    ahead: Relative, predecessor: Motion, leader: Motion, v: float, own: cacc.Parameters
) -> float:
    seen = Observation(v, WANTED, ahead, predecessor=predecessor, leader=leader)
    return float(cacc.cooperative(seen, own))


@pytest.mark.parametrize(
    ("ahead", "predecessor", "leader", "v", "a"),
    [
        (REST, STEADY, STEADY, 30.0, 0.0),
        # c1 = 0.5, xi = 1, omega_n = 0.2: alphas 0.5, 0.5, -0.3, -0.1, -0.04 (Plexe)
        (REST, Motion(30.0, 1.0), STEADY, 30.0, 0.5),
        (REST, STEADY, Motion(30.0, -2.0), 30.0, -1.0),
        (Relative(37.5, 2.0), STEADY, STEADY, 30.0, 0.6),
        (REST, STEADY, Motion(28.0, 0.0), 30.0, -0.2),
        (Relative(47.5, 0.0), STEADY, STEADY, 30.0, 0.4),
    ],
)
def test_cooperative_by_hand(
    ahead: Relative, predecessor: Motion, leader: Motion, v: float, a: float
) -> None:
    assert cooperative(ahead, predecessor, leader, v, cacc.Parameters()) == pytest.approx(
        a, abs=1e-12
    )


@pytest.mark.parametrize(
    ("predecessor", "leader", "own", "a"),
    [
        # half of each command; the accelerations that act do not count
        (
            Motion(30.0, 9.0, command=1.0),
            Motion(30.0, 9.0, command=-3.0),
            {"commanded": True},
            -1.0,
        ),
        # 0.3 times the reported speed of the vehicle ahead; the radar's does not count
        (Motion(32.0, 0.0), STEADY, {"reported_speed": True}, 0.6),
    ],
)
def test_cooperative_as_in_plexe(
    predecessor: Motion, leader: Motion, own: dict[str, bool], a: float
) -> None:
    ahead = Relative(37.5, 0.0)
    assert cooperative(ahead, predecessor, leader, 30.0, cacc.Parameters(**own)) == pytest.approx(
        a, abs=1e-12
    )


def test_cooperative_with_more_damping() -> None:
    law = cacc.Parameters(c1=0.25, xi=1.25, omega_n=0.4)
    # xi + sqrt(xi² - 1) = 2: alpha_3 = -(2.5 - 0.5) 0.4 = -0.8, alpha_4 = -0.25 · 2 · 0.4 = -0.2
    ahead = Relative(38.5, 1.0)
    a = cooperative(ahead, Motion(0.0, 0.4), Motion(29.0, 0.8), 30.0, law)
    assert a == pytest.approx(0.75 * 0.4 + 0.25 * 0.8 + 0.8 - 0.2 + 0.16, abs=1e-12)
