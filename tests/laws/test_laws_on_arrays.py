"""A law gives the same bits on floats and on arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.laws.by_hand import WANTED
from zenvoy.laws import (
    Motion,
    Observation,
    Output,
    Relative,
    builtin,
    clipped,
    larger,
    law_of,
    power,
    root,
    smaller,
    where,
)

NUMBERS = st.floats(-1e3, 1e3)
ROWS = st.lists(st.tuples(*[NUMBERS] * 9), min_size=1, max_size=5)


@pytest.mark.parametrize("name", list(builtin()))
@given(rows=ROWS)
def test_a_law_gives_the_same_bits_on_arrays(name: str, rows: list[tuple[float, ...]]) -> None:
    law = law_of(name)
    own = law.parameters()

    def seen(values: Any) -> Observation:
        speed, p, v, p_behind, v_behind, a, leader_v, leader_a, k_d = values
        ahead, behind = Relative(p, v), Relative(p_behind, v_behind)
        return Observation(
            speed,
            WANTED._replace(k_d=k_d),
            ahead,
            behind,
            sides=((ahead, behind), (behind, ahead)),
            predecessor=Motion(speed, a, distance=p, age_s=0.05, command=leader_a, steps=1.0),
            leader=Motion(leader_v, leader_a, distance=3.0 * p, age_s=0.1, command=a, steps=3.0),
            state=tuple(value + 0.0 * speed for value in law.state),
            period_s=0.1,
            acceleration=0.1 * v,
            length_m=5.0,
        )

    one_by_one = [numbers(law.acceleration(seen(row), own)) for row in rows]
    together = numbers(law.acceleration(seen(np.array(rows).T), own))
    np.testing.assert_array_equal(np.array(together).T, one_by_one)


def numbers(returned: Any) -> list[Any]:
    """Return all that a law returns."""
    output = returned if isinstance(returned, Output) else Output(returned)
    return [output.acceleration, *output.logged, *output.state]


@given(a=st.floats(), b=st.floats(), limit=st.floats(0, 1e3))
def test_choices_are_the_same_on_arrays(a: float, b: float, limit: float) -> None:
    for choose in (smaller, larger):
        np.testing.assert_array_equal(choose(np.array([a]), np.array([b])), [choose(a, b)])
    np.testing.assert_array_equal(clipped(np.array([a]), limit), [clipped(a, limit)])
    np.testing.assert_array_equal(root(np.array([a])), [root(a)])
    np.testing.assert_array_equal(where(np.array([a > b]), a, b), [where(a > b, a, b)])


@given(st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=20), st.integers(0, 16))
def test_powers_have_the_same_bits_on_floats_and_arrays(values: list[float], exponent: int) -> None:
    together = np.broadcast_to(power(np.array(values), exponent), len(values)).tolist()
    assert together == [power(value, exponent) for value in values]
    assert together == pytest.approx([value**exponent for value in values], rel=1e-13)


def test_a_power_has_no_negative_exponent() -> None:
    with pytest.raises(ValueError, match="exponent -1 is below 0"):
        power(2.0, -1)
