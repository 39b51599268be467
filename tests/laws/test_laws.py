"""The control laws match values computed by hand."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.laws.by_hand import REST, WANTED
from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import (
    Observation,
    Relative,
    Setpoint,
    builtin,
    clipped,
)
from zenvoy.laws.library import bcm, fm, mbcm


def following(ahead: Relative, v: float, setpoint: Setpoint = WANTED) -> float:
    return float(fm.following(Observation(v, setpoint, ahead)))


def bilateral(ahead: Relative, behind: Relative, v: float, setpoint: Setpoint = WANTED) -> float:
    return float(bcm.bilateral(Observation(v, setpoint, ahead, behind)))


def multi_node(
    sides: tuple[tuple[Relative, Relative], ...], own: mbcm.Parameters, v: float
) -> float:
    return float(mbcm.multi_node(Observation(v, WANTED, sides=sides), own))


@pytest.mark.parametrize(
    ("ahead", "v", "a"),
    [
        (Relative(47.5, 0.0), 30.0, 1.0),  # 0.1 · 10
        (Relative(37.5, -2.0), 30.0, -1.0),  # 0.5 · -2
        (Relative(37.5, 0.0), 20.0, 0.5),  # 0.05 · (30 - 20)
        (Relative(30.0, 4.0), 34.0, 1.05),  # -0.75 + 2 - 0.2
    ],
)
def test_following_by_hand(ahead: Relative, v: float, a: float) -> None:
    assert following(ahead, v) == pytest.approx(a, abs=1e-12)


@pytest.mark.parametrize(
    ("ahead", "behind", "v", "a"),
    [
        (Relative(40.0, 0.0), Relative(35.0, 0.0), 30.0, 0.5),  # 0.1 · 5
        (Relative(20.0, 1.0), Relative(20.0, -1.0), 30.0, 1.0),  # 0.5 · 2
        (Relative(20.0, 0.0), Relative(20.0, 0.0), 36.0, -0.3),  # 0.05 · -6
        (Relative(30.0, -2.0), Relative(45.0, 2.0), 26.0, -3.3),  # -1.5 - 2 + 0.2
    ],
)
def test_bilateral_by_hand(ahead: Relative, behind: Relative, v: float, a: float) -> None:
    assert bilateral(ahead, behind, v) == pytest.approx(a, abs=1e-12)


def test_acceleration_is_zero_in_equilibrium() -> None:
    assert following(REST, 30.0) == 0.0
    assert bilateral(REST, REST, 30.0) == 0.0
    # The bilateral law has no desired gap: any two equal ones will do.
    assert bilateral(Relative(12.0, 1.5), Relative(12.0, 1.5), 30.0) == 0.0


@given(st.floats(0.0, 60.0), st.floats(0.001, 1.0))
def test_speeds_converge_to_the_desired_one(v: float, k_c: float) -> None:
    """The paper's k_c (v - v_des) would drive speeds away from it."""
    wanted = WANTED._replace(k_c=k_c)
    for a in (following(REST, v, wanted), bilateral(REST, REST, v, wanted)):
        assert a == pytest.approx(k_c * (30.0 - v), abs=1e-12)
        assert (a > 0.0) == (v < 30.0)


@pytest.mark.parametrize(
    ("a", "within"), [(2.9, 2.9), (3.1, 3.0), (-3.1, -3.0), (-0.5, -0.5), (1e9, 3.0)]
)
def test_acceleration_is_limited(a: float, within: float) -> None:
    assert clipped(a, 3.0) == within
    assert clipped(a, 0.4) == max(-0.4, min(0.4, a))


@pytest.mark.parametrize(
    ("kind", "m", "weights"),
    [
        ("least-squares", 1, (1.0,)),
        ("least-squares", 3, (1 / 14, 4 / 14, 9 / 14)),
        ("uniform", 4, (0.25, 0.25, 0.25, 0.25)),
        ((0.5, 0.3, 0.2), 3, (0.5, 0.3, 0.2)),
        ((0.5, 0.3, 0.2), 2, (0.625, 0.375)),  # a shorter chain, the same sum
        ((0.0, 1.0), 1, (0.0,)),
    ],
)
def test_weights_of_chains(
    kind: str | tuple[float, ...], m: int, weights: tuple[float, ...]
) -> None:
    assert mbcm.weights_of(kind, m) == pytest.approx(weights, abs=1e-15)


@given(st.sampled_from(["least-squares", "uniform"]), st.integers(1, 100))
def test_weights_by_name_sum_to_one(kind: str, m: int) -> None:
    assert math.fsum(mbcm.weights_of(kind, m)) == pytest.approx(1.0, abs=1e-12)


def test_multi_node_by_hand() -> None:
    sides = (
        (Relative(40.0, 1.0), Relative(35.0, 0.0)),  # 0.1 · 5 + 0.5 · 1 = 1
        (Relative(70.0, 0.0), Relative(80.0, 2.0)),  # -1 - 1 = -2
    )
    # 0.2 · 1 + 0.8 · -2 + 0.05 · 10
    assert multi_node(sides, mbcm.Parameters(2, (0.2, 0.8)), 20.0) == pytest.approx(-0.9, abs=1e-12)


@given(st.floats(1, 100), st.floats(-5, 5), st.floats(1, 100), st.floats(-5, 5), st.floats(0, 40))
def test_multi_node_of_one_is_bilateral(
    p: float, v: float, p_behind: float, v_behind: float, own: float
) -> None:
    ahead, behind = Relative(p, v), Relative(p_behind, v_behind)
    one = multi_node(((ahead, behind),), mbcm.Parameters(1), own)
    assert one == pytest.approx(bilateral(ahead, behind, own), abs=1e-9)


def test_the_modes_of_the_library_are_those_of_the_messages() -> None:
    """MODE_FOLLOWER_STOPPER is that of FollowerStopper."""
    named = {name.replace("_", ""): number for name, number in pb.Mode.items()}
    for law in builtin().values():
        assert law.mode == named[f"MODE{law.name.replace('-', '')}".upper()]


def test_a_colour_is_a_laws_own() -> None:
    colours = [law.colour for law in builtin().values()]
    assert len(set(colours)) == len(colours)
