"""PI with saturation: the formulas of the paper on sequences, and the mean over its window."""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.laws import Observation, Relative, Setpoint, law_of
from zenvoy.laws.library.pi import Parameters, saturated

LENGTH_M = 5.0
SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=7.0)


class Instant(NamedTuple):
    """Own speed (m/s), gap from bumper to bumper (m), and speed of the vehicle ahead (m/s)."""

    speed: float
    gap: float
    leader: float


def commands(instants: list[Instant], period_s: float, own: Parameters) -> list[float]:
    """Return the commanded speeds of the law over a sequence, m/s."""
    state, found = law_of("PI").state, []
    for speed, gap, leader in instants:
        ahead = Relative(gap + LENGTH_M, leader - speed)
        seen = Observation(
            speed, SETPOINT, ahead, state=state, period_s=period_s, length_m=LENGTH_M
        )
        output = saturated(seen, own)
        state = output.state
        found.append(speed + own.tracking_s * output.acceleration)
    return found


def as_printed(instants: list[Instant]) -> list[float]:
    """Return the commands as the paper prints them, Eqs. 3 to 5, at one measurement a second."""
    speeds: deque[float] = deque(maxlen=38)
    found: list[float] = []
    for speed, gap, leader in instants:
        speeds.append(speed)
        target = sum(speeds) / len(speeds) + 1.0 * min(max((gap - 7.0) / 23.0, 0.0), 1.0)
        safe = max(2.0 * (leader - speed), 4.0)
        alpha = min(max((gap - safe) / 2.0, 0.0), 1.0)
        beta = 1.0 - 0.5 * alpha
        before = found[-1] if found else speed
        found.append(beta * (alpha * target + (1.0 - alpha) * leader) + (1.0 - beta) * before)
    return found


instants = st.builds(Instant, st.floats(0.0, 12.0), st.floats(0.0, 40.0), st.floats(0.0, 12.0))


@given(st.lists(instants, min_size=1, max_size=90))
def test_commands_are_those_of_the_paper(sequence: list[Instant]) -> None:
    assert commands(sequence, 1.0, Parameters()) == pytest.approx(as_printed(sequence), abs=1e-9)


@pytest.mark.parametrize("period_s", [0.02, 0.1, 0.3])
def test_the_mean_covers_its_window_whatever_the_period(period_s: float) -> None:
    """Far from the vehicle ahead and at rest in its command, the host drives at the mean + 1 m/s.

    The speed grows by 0.1 m/s every second, so the mean is that of half a window ago.
    """
    count = round(80.0 / period_s)
    sequence = [Instant(0.1 * k * period_s, 100.0, 0.1 * k * period_s) for k in range(count)]
    found = commands(sequence, period_s, Parameters())
    before, last = found[-2:]
    mean = 2.0 * last - before - 1.0  # as β is 1/2
    assert mean == pytest.approx(sequence[-1].speed - 0.1 * 38.0 / 2.0, abs=0.1 * period_s)
    early = round(20.0 / period_s)  # while the window is not full
    mean = 2.0 * found[early] - found[early - 1] - 1.0
    assert mean == pytest.approx(sequence[early].speed / 2.0, abs=0.1 * period_s)


def test_a_steady_flow_stays_as_it_is() -> None:
    steady = [Instant(6.5, 6.8, 6.5)] * 300
    assert commands(steady, 0.1, Parameters()) == pytest.approx([6.5] * 300, abs=1e-9)


def test_a_wave_hardly_changes_the_command() -> None:
    """The speed swings by 3 m/s every 20 s; the gap is wide enough to ignore that."""
    wave = [Instant(6.0 + 3.0 * (k // 100 % 2 * 2 - 1), 7.0, 6.0) for k in range(2000)]
    later = commands(wave, 0.1, Parameters())[1000:]
    assert max(later) - min(later) < 0.35
    assert max(abs(b - a) for a, b in pairwise(later)) < 0.05


def test_a_gap_that_is_too_short_follows_the_vehicle_ahead() -> None:
    assert commands([Instant(8.0, 4.0, 5.0)] * 3, 0.1, Parameters()) == pytest.approx([5.0] * 3)


def test_limits_that_cross_are_refused() -> None:
    with pytest.raises(ValueError, match="lower_gap_m"):
        Parameters(lower_gap_m=30.0)
