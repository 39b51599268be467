"""Theory of one vehicle behind another agrees with closed forms and with a search."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.analysis.theory.linear_cases import GAINS, PAPER
from zenvoy.analysis.theory.laws import (
    BCM,
    group_delay_s,
    is_string_stable,
    mbcm,
    peak_gain,
    total_delay_s,
    transfer,
)
from zenvoy.laws.library.mbcm import weights_of
from zenvoy.scenarios import Control, Gains

Floats = NDArray[np.float64]

OMEGA = np.geomspace(1e-3, 20.0, 4000)


def test_weights_of_mbcm_are_those_of_the_law() -> None:
    assert weights_of("least-squares", 3) == pytest.approx((1 / 14, 4 / 14, 9 / 14))
    assert weights_of("uniform", 4) == (0.25,) * 4
    assert mbcm(weights_of("least-squares", 1)) == BCM
    assert weights_of((0.5, 0.3, 0.2), 2) == pytest.approx((0.625, 0.375))


def test_the_delay_is_wait_plus_system_delay_plus_half_a_period() -> None:
    control = Control(v2v_wait_ms=11.0, system_delay_ms=89.0)
    assert total_delay_s(control, 100.0) == pytest.approx(0.15)
    assert total_delay_s(control, 100.0, predicts=True) == pytest.approx(0.05)


def test_transfer_by_hand() -> None:
    found = transfer(np.array([0.0, 1.0]), PAPER)
    assert found[0] == 1.0
    assert found[1] == pytest.approx((0.1 + 0.5j) / (-0.9 + 0.55j))
    late = np.exp(-0.2j)
    expected = (0.1 + 0.5j) * late / (-1.0 + (0.1 + 0.55j) * late)
    assert transfer(np.array([1.0]), PAPER, 0.2)[0] == pytest.approx(expected)


@given(GAINS)
def test_a_string_stable_law_amplifies_no_frequency(g: Gains) -> None:
    margin = g.k_c**2 + 2.0 * g.k_v * g.k_c - 2.0 * g.k_d
    assume(abs(margin) > 1e-3)
    largest = np.abs(transfer(OMEGA, g)).max()
    assert is_string_stable(g) == (largest <= 1.0 + 1e-9)
    peak = peak_gain(g)
    assert 0.9 * peak.gain <= max(1.0, largest) <= peak.gain + 1e-9  # the grid may miss the tip
    assert (peak.omega > 0.0) == (not is_string_stable(g))
    if peak.omega:
        beside = transfer(peak.omega * np.array([0.999, 1.0, 1.001]), g)
        assert np.argmax(np.abs(beside)) == 1


def test_peak_of_the_papers_gains() -> None:
    # u = 0.1475 / (1 + √(1 + 0.25 · 0.1475 / 0.01)), by hand
    peak = peak_gain(PAPER)
    assert peak.omega == pytest.approx(np.sqrt(0.1475 / (1.0 + np.sqrt(4.6875))))
    assert peak.gain == pytest.approx(np.sqrt(0.021651 / 0.016949), rel=1e-4)  # 1.130
    assert not is_string_stable(PAPER)
    assert is_string_stable(Gains(k_d=0.02625, k_v=0.5, k_c=0.05))  # κ² + 2 k_v κ = 2 k_d exactly


@settings(deadline=None, max_examples=30)
@given(GAINS)
def test_the_search_for_the_peak_starts_at_the_closed_form(g: Gains) -> None:
    assume(g.k_c**2 + 2.0 * g.k_v * g.k_c - 2.0 * g.k_d < -1e-2)
    closed, searched = peak_gain(g), peak_gain(g, 1e-9)
    assert searched.gain == pytest.approx(closed.gain, rel=1e-6)
    assert searched.omega == pytest.approx(closed.omega, rel=1e-2)


@settings(deadline=None, max_examples=60)
@given(GAINS, st.floats(0.05, 2.0))
def test_string_stability_with_a_lag_has_its_closed_form(g: Gains, lag: float) -> None:
    """1 / |H|² - 1 has the sign of c + (1 - 2 K T) u + T² u², where u = ω² and K = k_v + k_c."""
    both = g.k_v + g.k_c
    assume(both > 1.05 * lag * g.k_d)  # a single vehicle is stable
    c, b = both**2 - g.k_v**2 - 2.0 * g.k_d, 1.0 - 2.0 * both * lag
    lowest = c if b >= 0.0 else c - 0.25 * b**2 / lag**2
    assume(abs(lowest) > 1e-3)
    assert (peak_gain(g, 0.0, lag).gain == 1.0) == (lowest > 0.0)


def test_transfer_with_a_lag_by_hand() -> None:
    s, late = 0.4j, np.exp(-0.4j * 0.2) / (1.0 + 0.4j * 0.5)
    pull = (0.5 * s + 0.1) * late
    expected = pull / (s * s + pull + 0.05 * s * late)
    assert transfer(np.array([0.4]), PAPER, 0.2, 0.5)[0] == pytest.approx(expected)


def test_a_delay_raises_the_peak() -> None:
    peaks = [peak_gain(PAPER, tau).gain for tau in (0.0, 0.1, 0.2, 0.4)]
    assert peaks == sorted(peaks)
    tame = Gains(k_d=0.05, k_v=0.5, k_c=0.1)  # just string-stable
    assert peak_gain(tame, 1e-3).gain == 1.0
    assert peak_gain(tame, 1.0).gain > 1.0


@given(GAINS, st.floats(0.0, 0.3))
def test_slow_waves_pass_a_vehicle_in_k_c_over_k_d(g: Gains, tau: float) -> None:
    assert group_delay_s(0.0, g, tau) == pytest.approx(g.k_c / g.k_d, rel=1e-3, abs=1e-5)
