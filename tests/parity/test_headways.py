"""The smallest string-stable headways of Ploeg's loop, in theory and in runs of its vehicles."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
import pytest

from tests.parity.headways import TOLERANCE, Vehicle, gains_in_runs
from tests.parity.loops import LOOPS, Loop, gain, limit_in_theory
from tests.parity.tables import cells_of_page

BY_NAME: Final = {loop.name: loop for loop in LOOPS}
NEAR: Final = (0.98, 1.0 - TOLERANCE, 1.0 + TOLERANCE, 1.02)


def on_page(loop: Loop) -> list[float]:
    """Return what the page says of a loop: published, in theory, and in runs (s), and a part, %."""
    (row,) = [row for row in cells_of_page() if row[0] == loop.name]
    return [float(cell) for cell in row[1:]]


def near(loop: Loop) -> list[Vehicle]:
    """Return the loop 2 % below and above theory, and just below and above the page's result."""
    theory, run = limit_in_theory(loop), on_page(loop)[2]
    return [
        (loop, factor * of) for factor, of in zip(NEAR, (theory, run, run, theory), strict=True)
    ]


@cache
def gains() -> dict[Vehicle, np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    return gains_in_runs([vehicle for loop in LOOPS for vehicle in near(loop)])


@pytest.mark.parametrize("name", BY_NAME)
def test_limits_of_theory_are_those_published(name: str) -> None:
    """The headway for a delay of 0.02 s is published as 0.25 s; in theory it is 0.243 s."""
    loop = BY_NAME[name]
    limit = limit_in_theory(loop)
    assert limit == pytest.approx(
        {3.16: 3.162, 0.67: 0.6725, 0.25: 0.2432}[loop.published_s], abs=6e-4
    )
    assert on_page(loop)[:2] == pytest.approx([loop.published_s, limit], abs=6e-5)


def test_without_v2v_the_limit_is_known_in_closed_form() -> None:
    """For low frequencies the gain is 1 - (h² - 2 / k_p) ω² / 2."""
    assert limit_in_theory(LOOPS[0]) == pytest.approx(10.0**0.5, rel=1e-4)


@pytest.mark.parametrize("name", BY_NAME)
def test_runs_are_stable_above_the_limit_of_theory_and_unstable_below(name: str) -> None:
    below, *_, above = near(BY_NAME[name])
    assert gains()[below].max() > 1.0
    assert gains()[above].max() < 1.0


@pytest.mark.parametrize("name", BY_NAME)
def test_the_page_has_the_limit_of_the_runs(name: str) -> None:
    loop = BY_NAME[name]
    _, just_below, just_above, _ = near(loop)
    assert gains()[just_below].max() > 1.0
    assert gains()[just_above].max() < 1.0
    _, theory, run, off = on_page(loop)
    assert off == pytest.approx(100.0 * (run / theory - 1.0), abs=0.06)
    assert abs(off) < 2.0


@pytest.mark.parametrize("name", BY_NAME)
def test_gains_of_runs_are_those_of_theory(name: str) -> None:
    """Where a gain is small, so is what is left of the leader's motion after four vehicles."""
    for loop, headway_s in near(BY_NAME[name]):
        expected = gain(loop, headway_s, loop.motion.omega)
        counts = expected > 0.8
        assert counts.sum() >= 3
        assert gains()[loop, headway_s][counts] == pytest.approx(expected[counts], abs=4e-3)
