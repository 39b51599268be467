"""Theory of a string agrees with closed forms, and with a simulation in small steps."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.analysis.theory.linear_cases import MBCM3, PAPER
from zenvoy.analysis.theory.chain import Member, follow, frequency_response, is_stable, open_road
from zenvoy.analysis.theory.laws import BCM, FM, Coupling, mbcm, transfer
from zenvoy.laws.library.mbcm import weights_of
from zenvoy.scenarios import Gains

Floats = NDArray[np.float64]


MIXED = [FM, BCM, FM, MBCM3, BCM, MBCM3, BCM, FM]


def string(coupling: Coupling, n: int, delay_s: float, lag_s: float = 0.0) -> list[Member]:
    return open_road([Member(coupling, PAPER, delay_s, lag_s)] * n)


@pytest.mark.parametrize("lag_s", [0.0, 0.5])
def test_the_gain_of_an_fm_string_is_a_power_of_one_vehicles(lag_s: float) -> None:
    omega = np.array([0.0, 0.1, 0.27, 1.0, 3.0])
    found = frequency_response(omega, string(FM, 6, 0.2, lag_s), 0, ring=False)
    single = transfer(omega, PAPER, 0.2, lag_s)
    np.testing.assert_allclose(found, single[:, None] ** np.arange(6), rtol=1e-10)
    ring = frequency_response(omega, [Member(FM, PAPER, 0.2, lag_s)] * 6, 2, ring=True)
    np.testing.assert_allclose(ring, single[:, None] ** np.array([4, 5, 0, 1, 2, 3]), rtol=1e-10)


def test_two_vehicles_between_ends_by_hand() -> None:
    """With vehicle 2 under BCM and 3 under FM, x_2 = P (x_1 + x_3) / D and x_3 = H x_2."""
    s = 0.3j
    pull, own = 0.5 * s + 0.1, s * s + 0.05 * s
    h = pull / (own + pull)
    second = pull / (own + 2.0 * pull - pull * h)
    found = frequency_response(np.array([0.3]), string(BCM, 3, 0.0), 0, ring=False)
    np.testing.assert_allclose(found[0], [1.0, second, h * second])


def test_a_string_has_the_ends_of_the_open_road() -> None:
    members = string(MBCM3, 8, 0.1)
    sides = [member.coupling and len(member.coupling.behind) for member in members]
    assert sides == [None, 1, 2, 3, 3, 2, 1, 0]
    assert members[2].coupling == mbcm(weights_of("least-squares", 2))
    assert members[1].coupling == BCM
    assert members[7].coupling == FM
    np.testing.assert_allclose(
        frequency_response(np.array([0.2]), members, 3, ring=False)[0, 0], 0.0
    )  # vehicle 1 keeps its speed, whichever vehicle moves


def test_stable_and_unstable_strings_are_distinguished() -> None:
    stiff = Gains(k_d=0.1, k_v=2.0, k_c=0.05)
    assert is_stable(string(FM, 5, 0.15))
    assert is_stable([Member(BCM, stiff, 0.15)] * 5)
    assert not is_stable([Member(BCM, stiff, 0.25)] * 5)  # 4 k_v τ is above π/2
    assert is_stable([Member(FM, stiff, 0.25)] * 5)
    driven = Gains(k_d=0.1, k_v=0.5, k_c=-0.05)  # as the paper prints its sign
    assert is_stable([Member(FM, driven, 0.0)] * 5)
    assert not is_stable([Member(BCM, driven, 0.0)] * 5)


def brute(
    motion: Floats, dt: float, members: list[Member], source: int, ring: bool, every: int
) -> Floats:
    """Return speeds from small steps, with commands held back by their delay."""
    n = len(members)
    late = round(members[0].delay_s / dt)
    position, speed = np.zeros(n), np.zeros(n)
    waiting = [np.zeros(n)] * (late + 1)
    rows = []
    for k, v in enumerate(motion):
        speed[source] = v
        if k % every == 0:
            rows.append(speed.copy())
        a = np.zeros(n)
        for i, member in enumerate(members):
            if member.coupling is None:
                continue
            gains = member.gains
            a[i] = -gains.k_c * speed[i]
            for sign, weights in ((-1, member.coupling.ahead), (1, member.coupling.behind)):
                for j, weight in enumerate(weights, start=1):
                    other = (i + sign * j) % n
                    a[i] += weight * gains.k_d * (position[other] - position[i])
                    a[i] += weight * gains.k_v * (speed[other] - speed[i])
        waiting.append(a)
        acts = waiting.pop(0) if late else a
        position = position + dt * speed + 0.5 * dt * dt * acts
        speed = speed + dt * acts
    return np.array(rows)


@pytest.mark.parametrize(
    ("members", "ring", "source"),
    [
        (open_road([Member(law, PAPER, 0.2) for law in MIXED]), False, 0),
        (string(BCM, 7, 0.0), False, 3),
        ([Member(BCM, PAPER, 0.2), Member(FM, Gains(k_d=0.2, k_v=1.0), 0.2)] * 4, True, 2),
        ([Member(MBCM3, PAPER, 0.1)] * 9, True, 0),
    ],
)
def test_a_string_moves_like_a_brute_force_simulation(
    members: list[Member], ring: bool, source: int
) -> None:
    dt, every = 0.005, 20
    time = np.arange(12_000) * dt
    motion = -np.exp(-(((time - 8.0) / 2.0) ** 2)) * (1.0 + 0.3 * np.sin(2.0 * time))
    expected = brute(motion, dt, members, source, ring, every)
    found = follow(motion[::every], dt * every, members, source, ring=ring)
    np.testing.assert_allclose(found, expected, atol=6e-3)
