"""SPBCM: its formula by hand, how it ages into FM, and what it gains over PBCM."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.laws import Needs, Observation, Relative, Setpoint, law_of
from zenvoy.laws.library.bcm import bilateral
from zenvoy.laws.library.fm import following
from zenvoy.laws.library.spbcm import Parameters, shared
from zenvoy.links.distance import gaps
from zenvoy.scenarios import load
from zenvoy.studies.batches import run_batch

SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=30.0)
BEHIND = Relative(35.5, 0.4)


def seen(age_s: float, behind: Relative = BEHIND) -> Observation:
    return Observation(29.0, SETPOINT, Relative(38.0, -0.2), behind, behind_age_s=age_s)


@pytest.mark.parametrize(
    ("age_s", "a"),
    [
        (0.0, 0.1 * (38.0 - 35.5) + 0.5 * (-0.2 - 0.4) + 0.05),
        (10.0, 0.1 * (38.0 - 36.0) + 0.5 * (-0.2 - 0.3) + 0.05),
        (40.0, 0.1 * (38.0 - 37.5) + 0.5 * -0.2 + 0.05),
        (400.0, 0.1 * (38.0 - 37.5) + 0.5 * -0.2 + 0.05),
    ],
)
def test_acceleration_by_hand(age_s: float, a: float) -> None:
    assert shared(seen(age_s), Parameters()) == pytest.approx(a, abs=1e-12)


def test_it_begins_as_bcm_and_ends_as_fm() -> None:
    never = seen(math.nan, Relative(math.nan, math.nan))
    assert shared(seen(0.0), Parameters()) == pytest.approx(bilateral(seen(0.0)), abs=1e-15)
    assert shared(never, Parameters()) == following(never)


@given(st.lists(st.floats(0.0, 100.0) | st.just(math.nan), min_size=1, max_size=8))
def test_arrays_have_the_bits_of_floats(ages_s: list[float]) -> None:
    behind = [Relative(math.nan, math.nan) if math.isnan(age) else BEHIND for age in ages_s]
    alone = [float(shared(seen(*one), Parameters())) for one in zip(ages_s, behind, strict=True)]
    column = Relative(*(np.array(values) for values in zip(*behind, strict=True)))
    together = shared(
        seen(0.0)._replace(behind=column, behind_age_s=np.array(ages_s)), Parameters()
    )
    assert together.tolist() == alone


def test_its_linear_form_is_that_of_bcm() -> None:
    law = law_of("SPBCM")
    assert law.linear is not None
    assert law.linear(Parameters(), SETPOINT, 0) == ((1.0,), (1.0,), 0.1, 0.5, 0.05)


def test_a_law_that_shares_links_must_predict() -> None:
    with pytest.raises(ValueError, match="shares_links needs prediction"):
        Needs(behind=True, shares_links=True)


def gap_errors(scenario: str, *changes: str) -> np.ndarray:
    """Return the RMS error of the gaps in the last 60 of 120 s, m, for each of three seeds."""
    runs = [load(scenario, changes, seed=seed, duration_s=120.0) for seed in (1, 2, 3)]
    found = []
    for run in run_batch(runs, {"/fleet/truth": ["position"]}):
        gap = gaps(run.truth["position"][-600:], run.scenario.ring_length_m)
        found.append(np.sqrt(np.mean((gap - 37.5) ** 2)))
    return np.array(found)


PBCM = "control.schedule.0.model=PBCM"


@pytest.mark.parametrize("scenario", ["beyond/case-15-bursts", "beyond/case-16-bursts"])
def test_it_halves_the_gap_error_of_pbcm_in_bursts(scenario: str) -> None:
    """In docs/beyond-the-paper.md the errors differ by a factor of 2.9 in steady traffic."""
    assert gap_errors(scenario).mean() < 0.5 * gap_errors(scenario, PBCM).mean()


def test_it_is_as_good_as_pbcm_without_losses() -> None:
    own = gap_errors("paper/case-15", "control.schedule.0.model=SPBCM")
    assert own == pytest.approx(gap_errors("paper/case-15"), rel=0.01)
