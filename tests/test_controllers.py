"""The control laws at points worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.vehicles.controllers import Law, bilateral, following, limited
from zenvoy.vehicles.relative import Relative

LAW = Law(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=30.0, a_max=3.0)
REST = Relative(37.5, 0.0)


@pytest.mark.parametrize(
    ("ahead", "v", "a"),
    [
        (Relative(47.5, 0.0), 30.0, 1.0),  # 0.1 · 10
        (Relative(37.5, -2.0), 30.0, -1.0),  # 0.5 · -2
        (Relative(37.5, 0.0), 20.0, 0.5),  # 0.05 · (30 - 20)
        (Relative(30.0, 4.0), 34.0, 1.05),  # -0.75 + 2 - 0.2
    ],
)
def test_following(ahead: Relative, v: float, a: float) -> None:
    assert following(ahead, v, LAW) == pytest.approx(a, abs=1e-12)


@pytest.mark.parametrize(
    ("ahead", "behind", "v", "a"),
    [
        (Relative(40.0, 0.0), Relative(35.0, 0.0), 30.0, 0.5),  # 0.1 · 5
        (Relative(20.0, 1.0), Relative(20.0, -1.0), 30.0, 1.0),  # 0.5 · 2
        (Relative(20.0, 0.0), Relative(20.0, 0.0), 36.0, -0.3),  # 0.05 · -6
        (Relative(30.0, -2.0), Relative(45.0, 2.0), 26.0, -3.3),  # -1.5 - 2 + 0.2
    ],
)
def test_bilateral(ahead: Relative, behind: Relative, v: float, a: float) -> None:
    assert bilateral(ahead, behind, v, LAW) == pytest.approx(a, abs=1e-12)


def test_nothing_to_do_in_equilibrium() -> None:
    assert following(REST, 30.0, LAW) == 0.0
    assert bilateral(REST, REST, 30.0, LAW) == 0.0
    # The bilateral law has no desired gap: any two equal ones will do.
    assert bilateral(Relative(12.0, 1.5), Relative(12.0, 1.5), 30.0, LAW) == 0.0


@given(st.floats(0.0, 60.0), st.floats(0.001, 1.0))
def test_speeds_are_drawn_to_the_desired_one(v: float, k_c: float) -> None:
    """The paper's k_c (v - v_des) would drive them away from it."""
    law = replace(LAW, k_c=k_c)
    for a in (following(REST, v, law), bilateral(REST, REST, v, law)):
        assert a == pytest.approx(k_c * (30.0 - v), abs=1e-12)
        assert (a > 0.0) == (v < 30.0)


@pytest.mark.parametrize(
    ("a", "within"), [(2.9, 2.9), (3.1, 3.0), (-3.1, -3.0), (-0.5, -0.5), (1e9, 3.0)]
)
def test_limit(a: float, within: float) -> None:
    assert limited(a, LAW) == within
    assert limited(a, replace(LAW, a_max=0.4)) == max(-0.4, min(0.4, a))
