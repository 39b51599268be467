"""Which vehicles take part in which cycles follows from the faults of their processes."""

from __future__ import annotations

from typing import Any, Final

from hypothesis import given
from hypothesis import strategies as st

from tests.faults import scenario_with
from zenvoy.scenarios import Attendance

SIZE, CYCLES = 5, 40
RESTART: Final = {"duration_s": CYCLES / 10, "on_vehicle_loss": "restart"}


def of(*faults: dict[str, Any]) -> Attendance:
    return Attendance(scenario_with(faults, size=SIZE, **RESTART))


def absent(there: Attendance, vehicle: int) -> list[int]:
    return [cycle for cycle in range(CYCLES) if not there.takes_part(vehicle, cycle)]


def test_a_cycle_counts_if_it_begins_within_a_fault() -> None:
    there = of(
        {"type": "process-frozen", "vehicles": "2", "at_s": 1.05, "duration_s": 0.3},
        {"type": "process-killed", "vehicles": "3-4", "at_s": 2.0, "duration_s": 0.5},
        {"type": "process-killed", "vehicles": "3", "at_s": 3.01, "duration_s": 0.01},
    )
    assert [absent(there, vehicle) for vehicle in range(1, SIZE + 1)] == [
        [],
        [11, 12, 13],
        [20, 21, 22, 23, 24, 31],  # a process that is killed misses at least a cycle
        [20, 21, 22, 23, 24],
        [],
    ]
    assert (there.killed_at(20), there.joining_at(25), there.joining_at(14)) == ([3, 4], [3, 4], [])
    assert there.there(20) == [1, 2, 5]


def test_nobody_joins_at_the_end_of_the_run() -> None:
    there = of({"type": "process-killed", "vehicles": "2", "at_s": 1.0, "duration_s": 9.0})
    assert absent(there, 2) == list(range(10, CYCLES))
    assert there.joining_at(CYCLES) == []


def test_a_fault_that_ends_before_a_cycle_begins_freezes_nothing() -> None:
    there = of({"type": "process-frozen", "vehicles": "2", "at_s": 1.01, "duration_s": 0.05})
    assert absent(there, 2) == []


@given(
    spans=st.lists(st.tuples(st.integers(0, 50), st.integers(1, 30)), max_size=4),
    kinds=st.lists(st.sampled_from(["process-frozen", "process-killed"]), min_size=4, max_size=4),
)
def test_the_next_cycle_is_the_first_with_the_vehicle(
    spans: list[tuple[int, int]], kinds: list[str]
) -> None:
    faults, at = [], 0
    for (apart, lasts), kind in zip(spans, kinds, strict=False):
        at += apart + 1  # one after the other
        faults.append(
            {"type": kind, "vehicles": "3", "at_s": at / 10, "duration_s": (lasts - 0.5) / 10}
        )
        at += lasts
    there = of(*faults)
    for cycle in range(CYCLES + 1):
        rest = [c for c in range(cycle, CYCLES) if 3 in there.there(c)]
        assert there.next(3, cycle) == (rest[0] if rest else CYCLES)
        if cycle < CYCLES:
            assert (3 in there.there(cycle)) == there.takes_part(3, cycle)
