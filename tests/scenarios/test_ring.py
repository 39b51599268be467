"""On the ring of human drivers a wave comes by itself, and goes where one car is controlled."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest

from zenvoy.analysis.theory.laws import is_string_stable
from zenvoy.laws import Setpoint, law_of
from zenvoy.laws.library import idm
from zenvoy.scenarios import Gains, load
from zenvoy.studies.batches import run_batch

LAWS: Final = {"nobody": "ring/humans", "FollowerStopper": "ring/follower-stopper", "PI": "ring/pi"}


def spreads(name: str) -> tuple[float, float]:
    """Return the standard deviation of speed in the 50 s before 300 s and before 500 s, m/s."""
    (run,) = run_batch([load(name, duration_s=500.0)], {"/fleet/truth": ("speed",)})
    speed = run.truth["speed"]
    return float(speed[2500:3000].std()), float(speed[4500:5000].std())


@pytest.mark.parametrize(("car", "name"), LAWS.items())
def test_one_controlled_car_ends_the_wave(car: str, name: str) -> None:
    before, after = spreads(name)
    assert before > 1.5
    assert (after > 3.0) if car == "nobody" else (after < 0.5)


def test_the_drivers_of_the_ring_are_string_unstable_at_its_steady_speed() -> None:
    scenario = load("ring/humans").scenario
    own = idm.Parameters(**dict(scenario.control.parameters))
    speed = scenario.control.desired_speed_mps
    bumper_gap_m = scenario.fleet.gap_m - scenario.fleet.length_m
    assert idm.equilibrium_gap_m(own, speed) == pytest.approx(bumper_gap_m, rel=2e-3)
    linear = law_of("IDM").linear
    assert linear is not None
    setpoint = Setpoint(k_d=0.0, k_v=0.0, k_c=0.0, p_des=np.nan, v_des=speed)
    _, _, k_d, k_v, k_c = linear(own, setpoint, 0)
    assert not is_string_stable(Gains(k_d=k_d, k_v=k_v, k_c=k_c))
