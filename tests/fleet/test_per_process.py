"""How many vehicles share a process."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.fleet.per_process import MANY, PerProcessError, crowd, per_process_of


@pytest.mark.parametrize(("asked", "found"), [(1, 1), ("1", 1), ("250", 250), ("auto", 500)])
def test_a_number_or_a_process_for_each_processor(asked: int | str, found: int) -> None:
    assert per_process_of(asked, 1_000, cores=2) == found


@given(size=st.integers(2, 1_000), cores=st.integers(1, 128))
def test_no_vehicle_is_left_alone(size: int, cores: int) -> None:
    placed = vehicle_processes(size, per_process_of("auto", size, cores))
    assert len(placed) <= cores or size < 2 * cores
    assert all(one.is_shared for one in placed) or size <= cores


@pytest.mark.parametrize(
    ("asked", "text"),
    [
        ("0", "0: is not at least 1"),
        (-3, "-3: is not at least 1"),
        ("many", "many: is no number of vehicles; allowed: 1 or more, or auto"),
        ("2.5", "2.5: is no number of vehicles; allowed: 1 or more, or auto"),
    ],
)
def test_anything_else_is_refused(asked: int | str, text: str) -> None:
    with pytest.raises(PerProcessError) as caught:
        per_process_of(asked, 1_000)
    assert str(caught.value) == text


@given(size=st.integers(2, 5_000), per_process=st.integers(1, 500), cores=st.integers(1, 64))
def test_many_processes_have_a_hint_with_a_way_out(size: int, per_process: int, cores: int) -> None:
    placed = vehicle_processes(size, per_process)
    assert (crowd(size, per_process, cores) is not None) == (len(placed) > MANY * cores)
    assert crowd(size, per_process_of("auto", size, cores), cores) is None


def test_the_hint_names_the_numbers_and_the_option() -> None:
    assert crowd(1_000, 1, 2) == (
        "1000 processes of vehicles share 2 processors, and may not all start within the stall "
        "limit; --vehicles-per-process auto starts one for each processor"
    )
