"""The figures of the live table are those of the run, and its sparklines have their shape."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.analysis.view.figures import BLOCKS, PLAIN, figures_of, sparkline
from zenvoy.analysis.view.picture import COLUMNS, TOTALS, Picture

NAN: Final = float("nan")


@pytest.mark.parametrize(
    ("values", "width", "expected"),
    [
        ([0, 1, 2, 3, 4, 5, 6, 7], 8, BLOCKS),
        ([7, 0], 8, "█▁"),
        ([0, 0, 7, 7], 2, "▁█"),
        ([2, 2, 2], 3, "▁▁▁"),
        ([NAN, 0, 1], 3, " ▁█"),
        ([NAN, NAN], 2, "  "),
        ([], 5, " "),
    ],
)
def test_a_sparkline_has_the_shape_of_its_values(
    values: list[float], width: int, expected: str
) -> None:
    assert sparkline(np.array(values, np.float64), width) == expected


@given(st.lists(st.floats(-1e6, 1e6) | st.just(NAN), min_size=1), st.integers(1, 50))
def test_a_sparkline_fits_and_has_its_signs_only(values: list[float], width: int) -> None:
    made = sparkline(np.array(values), width, PLAIN)
    assert len(made) == min(width, len(values))
    assert set(made) <= {*PLAIN, " "}


def test_the_figures_are_those_of_the_samples_and_the_newest_cycle() -> None:
    totals = np.full((3, len(TOTALS)), NAN, np.float32)

    def put(name: str, *values: float) -> None:
        totals[:, list(TOTALS).index(name)] = values

    put("mean_speed", 20, 10, 15)
    put("smallest_gap", 30, 12, np.inf)  # inf: there is no gap
    put("oldest", -1, 0.1, 0.5)  # -1: there are no data yet
    put("delivered", 6, 4, 8)
    put("late", 0, 2, 0)
    put("lost", 2, 1, 1)
    put("collided", 0, 1, 1)
    put("wall", 5.0, 5.1, 5.2)
    columns = np.full((len(COLUMNS), 4), NAN, np.float32)
    columns[list(COLUMNS).index("age")] = (0.2, NAN, 0.1, 0.5)
    columns[list(COLUMNS).index("mode")] = (4, 4, NAN, 6)
    samples: dict[str, NDArray[Any]] = {"cycle": np.array([0, 5, 10], np.uint32), "totals": totals}
    found = figures_of(samples, Picture(np.zeros(4), columns, totals[-1]), 0.15)
    assert found.real_time_factor == pytest.approx(10 * 0.15 / 0.2, rel=1e-5)
    shown = {measure.name: (measure.now, measure.worst) for measure in found.measures}
    assert shown == {
        "mean speed": (15, 10),
        "smallest gap": (12, 12),
        "oldest data": (0.5, 0.5),
        "frames lost": (20, 25),
        "frames late": (0, 25),
    }
    assert [vehicle for vehicle, _ in found.late] == [4, 1]
    assert found.modes == {4: 2, 6: 1}


def test_nothing_is_known_before_the_first_cycle() -> None:
    samples: dict[str, NDArray[Any]] = {
        "cycle": np.zeros(0, np.uint32),
        "totals": np.zeros((0, len(TOTALS))),
    }
    found = figures_of(samples, None, 0.1)
    assert np.isnan(found.real_time_factor)
    assert all(np.isnan(measure.now) for measure in found.measures)
    assert (found.late, found.modes) == ((), {})
