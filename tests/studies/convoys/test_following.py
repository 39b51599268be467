"""A follower of a fit moves as it does in a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.studies.convoys.conftest import convoy_of, scenario_of
from zenvoy.laws import Law, Observation, Output, law_of
from zenvoy.laws.errors import LawError
from zenvoy.laws.parameters import parameters_of
from zenvoy.scenarios import roster, setpoint_at
from zenvoy.studies.convoys.following import Pair, Timing, driven, pairs_of


@pytest.mark.parametrize(
    ("control", "period_ms"),
    [
        ({"model": "FM"}, 100.0),
        ({"model": "FM", "system_delay_ms": 250.0}, 100.0),
        ({"model": "ACC", "parameters": {"headway_s": 0.9}}, 100.0),
        ({"model": "IDM", "parameters": {"headway_s": 1.3}, "system_delay_ms": 0.0}, 50.0),
        ({"model": "IDM", "acceleration_limit_mps2": 0.8}, 100.0),
    ],
    ids=str,
)
def test_it_moves_as_in_a_run(tmp_path: Path, control: dict[str, Any], period_ms: float) -> None:
    scenario = scenario_of(control, period_ms=period_ms)
    convoy = convoy_of(scenario, tmp_path / "run")
    law = law_of(scenario.control.model)
    parameters = parameters_of(law.parameters, dict(scenario.control.parameters))
    timing = Timing.of(scenario)
    setpoint = setpoint_at(roster(scenario)[1].targets, 0)
    # The leader's speed is a line within each cycle, but not that of the vehicle behind it.
    for pair, least_m in zip(pairs_of(convoy, timing.period_s), (1e-9, 5e-3), strict=True):
        found = driven(law, parameters, setpoint, pair, timing)
        np.testing.assert_allclose(found.gap, pair.gap, atol=least_m)
        np.testing.assert_allclose(found.speed, pair.own, atol=least_m)


def test_a_follower_that_runs_into_the_car_ahead_stays_behind_it() -> None:
    always = Law(name="fast", acceleration=lambda *_: 1.0)
    pair = Pair(car="b", ahead=(5.0,) * 40, own=np.full(40, 9.0), gap=np.full(40, 3.0))
    found = driven(always, None, _setpoint(), pair, _timing())
    assert found.gap.min() == 0.0
    assert found.gap[-1] == 0.0
    assert found.speed[-1] == 5.0


def test_a_vehicle_that_stands_stays_there() -> None:
    braking = Law(name="slow", acceleration=lambda *_: -2.0)
    pair = Pair(car="b", ahead=(5.0,) * 40, own=np.full(40, 3.0), gap=np.full(40, 30.0))
    found = driven(braking, None, _setpoint(), pair, _timing())
    assert found.speed[-1] == 0.0
    # 0.1 s until the command, and then v²/2a
    assert found.gap[-1] == pytest.approx(30.0 + 3.9 * 5.0 - 0.3 - 3.0**2 / 4.0)


def test_a_law_may_keep_a_state() -> None:
    def counting(seen: Observation, _: object) -> Output:
        (count,) = seen.state
        return Output(0.0 if count < 20 else 1.0, state=(count + 1.0,))

    law = Law(name="counting", acceleration=counting, state=(0.0,))
    pair = Pair(car="b", ahead=(5.0,) * 41, own=np.full(41, 5.0), gap=np.full(41, 30.0))
    found = driven(law, None, _setpoint(), pair, _timing())
    assert found.speed[21] == 5.0
    assert found.speed[-1] == pytest.approx(5.0 + 1.9)


def test_a_law_that_raises_is_named_and_one_outside_its_domain_is_not() -> None:
    wrong = Law(name="wrong", acceleration=lambda *_: int("x"))
    zero = Law(name="zero", acceleration=lambda seen, _: 1.0 / (seen.speed - seen.speed))
    nan = Law(name="nan", acceleration=lambda *_: float("nan"))
    pair = Pair(car="b", ahead=(5.0,) * 3, own=np.full(3, 5.0), gap=np.full(3, 30.0))
    with pytest.raises(LawError, match="law wrong raised ValueError"):
        driven(wrong, None, _setpoint(), pair, _timing())
    for law in (zero, nan):
        with pytest.raises(ArithmeticError):
            driven(law, None, _setpoint(), pair, _timing())


def _timing() -> Timing:
    return Timing(100_000_000, 100_000_000, -3.0, 3.0, 5.0)


def _setpoint() -> Any:
    return setpoint_at(roster(scenario_of({}))[1].targets, 0)
