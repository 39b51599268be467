"""The gain from head to tail agrees with closed forms, dense grids, and a scenario."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.analysis.theory.chain import Member, frequency_response, is_stable, open_road
from zenvoy.analysis.theory.head_to_tail import head_to_tail
from zenvoy.analysis.theory.laws import BCM, FM, Coupling, is_string_stable, mbcm, peak_gain
from zenvoy.analysis.theory.of_run import NoTheoryError
from zenvoy.analysis.theory.of_scenario import head_to_tail_gain, string_of
from zenvoy.laws.library.mbcm import weights_of
from zenvoy.scenarios import Gains, load

GAINS = st.builds(Gains, k_d=st.floats(0.02, 1.0), k_v=st.floats(0.1, 1.5), k_c=st.floats(0.0, 1.0))
DELAYS = st.sampled_from([0.0, 0.15])
LAGS = st.sampled_from([0.0, 0.5])


@settings(deadline=None)
@given(gains=GAINS, size=st.integers(2, 12), delay_s=DELAYS, lag_s=LAGS)
def test_followers_multiply_the_gain_of_one(
    gains: Gains, size: int, delay_s: float, lag_s: float
) -> None:
    members = open_road([Member(FM, gains, delay_s, lag_s)] * size)
    if not is_stable(members):
        assert head_to_tail(members).gain == math.inf
        return
    one = peak_gain(gains, delay_s, lag_s)
    found = head_to_tail(members)
    assert found.gain == pytest.approx(one.gain ** (size - 1), rel=1e-6)
    if one.gain > 1.01:
        assert found.omega == pytest.approx(one.omega, rel=1e-2)
    if (
        delay_s == lag_s == 0.0
        and abs(2.0 * gains.k_d - gains.k_c**2 - 2.0 * gains.k_v * gains.k_c) > 1e-3
    ):
        assert (found.gain == 1.0) == is_string_stable(gains)


@settings(deadline=None, max_examples=15)
@given(
    gains=GAINS,
    size=st.integers(3, 20),
    coupling=st.sampled_from([BCM, mbcm(weights_of("least-squares", 3))]),
)
def test_no_frequency_of_a_dense_grid_has_a_larger_gain(
    gains: Gains, size: int, coupling: Coupling
) -> None:
    members = open_road([Member(coupling, gains, 0.1)] * size)
    if is_stable(members):
        omega = np.geomspace(1e-3, 30.0, 6000)
        largest = np.abs(frequency_response(omega, members, 0, ring=False)[:, -1]).max()
        assert head_to_tail(members).gain >= 0.9999 * max(1.0, largest)


def test_a_scenario_gives_its_string() -> None:
    """FM by hand has a wait of 50 ms, a system delay of 100 ms, half a period, and its lag."""
    settings = ("road.type=open", "control.model=FM", "fleet.size=5")
    delays = ("control.v2v_wait_ms=50", "control.system_delay_ms=100", "period_ms=100")
    own = ("control.gains.k_v=0.3", "vehicle.actuator_lag_s=0.25")
    scenario = load("quickstart", (*settings, *delays, *own)).scenario
    gains = Gains(k_d=0.1, k_v=0.3, k_c=scenario.control.gains.k_c)
    for member in string_of(scenario)[1:]:
        assert (member.coupling, member.gains) == (FM, gains)
        assert member.delay_s == pytest.approx(0.2)
        assert member.lag_s == 0.25
    assert head_to_tail_gain(scenario) == pytest.approx(peak_gain(gains, 0.2, 0.25).gain ** 4)


@pytest.mark.parametrize(
    ("setting", "why"),
    [
        ("road.type=ring", "a ring has no head"),
        ("control.neighbour_state=position", "radar readings"),
        ("control.gains.k_d=0", "k_d is 0"),
        ("control.model=CACC", "no linear form"),
    ],
)
def test_a_scenario_without_theory_is_refused_with_the_reason(setting: str, why: str) -> None:
    scenario = load("quickstart", ("road.type=open", setting)).scenario
    with pytest.raises(NoTheoryError, match=why):
        head_to_tail_gain(scenario)
