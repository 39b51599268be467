"""Arrays of vehicles have the covariances, errors and laws of single vehicles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.topics import vehicle_name
from zenvoy.laws import Law, Observation, Output, Relative, builtin, where
from zenvoy.laws.errors import LawError
from zenvoy.scenarios import Limits, Scenario, roster
from zenvoy.vehicles.arrays.aims import Schedule
from zenvoy.vehicles.arrays.covariances import Covariances
from zenvoy.vehicles.arrays.decisions import Decider, Occasion
from zenvoy.vehicles.arrays.errors import ReadingErrors
from zenvoy.vehicles.arrays.rows import ALL
from zenvoy.vehicles.arrays.trial import fault_on_arrays
from zenvoy.vehicles.arrays.view import Known, Seen, View
from zenvoy.vehicles.decision import Controller
from zenvoy.vehicles.estimator import Filter, ReadingError

PERIOD_S: Final = 0.1
SIGMA: Final = 0.5
FILTERS: Final = 4

VARIANCES: Final = st.sampled_from([0.25, 1.0, 1.5625, 9.0])
# For each filter: how many periods have passed, and the variances of its readings.
STEP: Final = st.lists(
    st.tuples(st.integers(1, 6), VARIANCES, VARIANCES), min_size=FILTERS, max_size=FILTERS
)


@given(st.lists(STEP, min_size=1, max_size=12), st.integers(0, 60))
def test_covariances_are_those_of_single_filters(
    steps: list[list[tuple[int, float, float]]], steady: int
) -> None:
    """The bits are equal whatever readings are missed, and however they change in size."""
    steps = steps + [[(1, b, c) for _, b, c in steps[-1]]] * steady
    together = Covariances(PERIOD_S, SIGMA, 2, FILTERS)
    alone = [Filter(PERIOD_S, SIGMA) for _ in range(FILTERS)]
    for number, step in enumerate(steps):
        periods, variances = np.array([p for p, _, _ in step]), np.array([r for _, *r in step]).T
        if number == 0:
            together.start(ALL, variances)
        else:
            together.step(ALL, 1 if (periods == 1).all() else periods, variances)
        for filter_, (missed, *r) in zip(alone, step, strict=True):
            filter_.step([0.0] * missed, (37.5, 0.0), tuple(r))
    std = np.array([filter_.std for filter_ in alone]).T
    assert together.std().tolist() == std.tolist()


@given(st.lists(st.lists(st.floats(-90.0, 90.0), min_size=3, max_size=3), min_size=1, max_size=20))
def test_variances_are_those_of_single_readings(values: list[list[float]]) -> None:
    together = ReadingErrors(ReadingError(0.1, 37.5), 3)
    alone = [ReadingError(0.1, 37.5) for _ in range(3)]
    for row in values:
        found = together.variance(ALL, np.array(row)).tolist()
        assert found == [error.variance(value) for error, value in zip(alone, row, strict=True)]


@pytest.mark.parametrize("name", builtin())
def test_every_law_of_the_library_takes_arrays(name: str) -> None:
    law = builtin()[name]
    assert fault_on_arrays(law, law.parameters(), 10.0) is None


def with_a_branch(seen: Observation, _: Any) -> Any:
    return 1.0 if seen.speed > 10.0 else 0.0


def by_the_mean(seen: Observation, _: Any) -> Any:
    return np.mean(seen.speed)


def one_too_many(seen: Observation, _: Any) -> Any:
    return Output(seen.speed, logged=(seen.speed / 0.0,))


def by_a_power(seen: Observation, _: Any) -> Any:
    return 0.3 * (1.0 - (seen.speed / 33.0) ** 2)


def by_a_power_where(seen: Observation, _: Any) -> Any:
    return 0.3 * where(seen.speed > 5.0, seen.speed, 5.0) ** 4


def by_exp(seen: Observation, _: Any) -> Any:
    return np.exp(-seen.speed)


def hidden(seen: Observation, _: Any) -> Any:
    """Differ in the last bit for an eighth of all speeds, on arrays that refuse nothing."""
    if isinstance(seen.speed, float):
        return seen.speed
    plain = np.asarray(seen.speed)
    return np.where(np.floor(64.0 * plain) % 8.0 == 5.0, np.nextafter(plain, 100.0), plain)


def list_of_two(_seen: Observation, _: Any) -> Any:
    return np.array([1.0, 2.0])


def ragged(_seen: Observation, _: Any) -> Any:
    return (1.0, (2.0,))


def text(_seen: Observation, _: Any) -> Any:
    return "fast"


def of_another_shape(seen: Observation, _: Any) -> Any:
    return seen.speed if isinstance(seen.speed, float) else seen.speed[:2]


OTHER_BITS = "which gives other bits on arrays than on floats"


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (with_a_branch, "it raises ValueError"),
        (by_a_power, f"it uses **, {OTHER_BITS}"),
        (by_a_power_where, f"it uses **, {OTHER_BITS}"),
        (by_exp, f"it uses numpy.exp, {OTHER_BITS}"),
        (by_the_mean, f"it uses numpy.add.reduce, {OTHER_BITS}"),
        (hidden, "it gives other values on arrays than on floats"),
        (list_of_two, "it returns array([1., 2.]), which is no number"),
        (ragged, "it returns (1.0, (2.0,)), which is no number"),
        (text, "it returns 'fast', which is no number"),
        (of_another_shape, "it returns arrays of another shape than it is given"),
        (one_too_many, "it raises ZeroDivisionError"),
    ],
)
def test_a_law_that_does_not_take_arrays_is_refused_with_the_reason(
    function: Any, expected: str
) -> None:
    fault = fault_on_arrays(Law(name="mine", acceleration=function), None, 10.0)
    assert fault is not None
    assert fault.startswith(expected)


@dataclass(frozen=True)
class Limit:
    """Speed, m/s, beyond which a law fails."""

    mps: float = 20.0


def fails_when_fast(seen: Observation, own: Limit) -> Any:
    return where(seen.speed > own.mps, float("nan"), 0.0)


def test_a_law_that_fails_for_one_vehicle_names_that_vehicle() -> None:
    scenario = Scenario()
    count, size = 80, 40
    state = Relative(np.full(count, 37.5), np.zeros(count))
    speed = np.full(count, 10.0)
    speed[46] = 25.0  # vehicle 7 of the second run
    seen = Seen(Known(state), Known(state), speed)
    view = View(radar=state, read=seen, acceleration=np.zeros(count))
    law = Law(name="mine", acceleration=fails_when_fast, parameters=Limit)
    aims = Schedule([*roster(scenario), *roster(scenario)]).at(0)
    names = [vehicle_name(vehicle, size) for vehicle in range(1, size + 1)]
    decider = Decider([Limits(-3.0, 3.0)] * count, names, PERIOD_S, length_m=5.0)
    with pytest.raises(LawError, match="law mine returned nan") as caught:
        decider.decide(
            Occasion(
                cycle=0,
                in_force=[(Controller(law, Limit(), 64), ALL)],
                view=view,
                aims=aims,
                uniform=lambda *_: speed,
            )
        )
    assert caught.value.process == "vehicle-07"


def test_a_filter_that_starts_late_does_not_disturb_the_others() -> None:
    """One of them has missed a measurement by then, and goes on by itself."""
    r = np.ones((2, 1))
    together = Covariances(PERIOD_S, SIGMA, 2, 2)
    alone = [Filter(PERIOD_S, SIGMA) for _ in range(2)]
    first, second = np.array([0]), np.array([1])
    together.start(first, r)
    together.step(first, np.array([3]), r)
    together.start(second, r)
    together.step(ALL, 1, np.ones((2, 2)))
    for filter_, missed in zip(alone, ([0, 3, 1], [0, 1]), strict=True):
        for periods in missed:
            filter_.step([0.0] * periods, (37.5, 0.0), (1.0, 1.0))
    assert together.std().tolist() == np.array([one.std for one in alone]).T.tolist()
