"""A step waits for one machine alone from the last message of the others to its own last one."""

from __future__ import annotations

from collections.abc import Iterable

from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.latecomers import Late, Latecomers

HOSTS = {1: "alpha", 2: "alpha", 3: "beta", 4: "gamma"}


def latecomer(arrivals: Iterable[tuple[int, int]], hosts: dict[int, str] = HOSTS) -> Late | None:
    """Return who is late if messages of these vehicles come, each after a wait, ns."""
    now_ns = 0

    def receive() -> None:
        nonlocal now_ns
        now_ns += next(waits)

    late = Latecomers(lambda: now_ns)
    late.hosts.update(hosts)
    arrivals = list(arrivals)
    waits = iter([waits_ns for _, waits_ns in arrivals])
    for vehicle, _ in arrivals:
        late.timed(lambda call: call(), receive)
        now_ns += 1_000  # of work, which is no wait
        late.came(vehicle)
    return late.ended()


def test_the_machine_that_comes_last_is_late_by_the_wait_for_it_alone() -> None:
    assert latecomer([(1, 5), (3, 20), (4, 0), (2, 7), (2, 8)]) == Late("alpha", 15)


def test_messages_in_the_queue_are_not_late() -> None:
    assert latecomer([(1, 0), (2, 0), (4, 0), (3, 0)]) == Late("gamma", 0)


def test_a_machine_that_nobody_waits_for_is_there_from_the_start() -> None:
    assert latecomer([(3, 9)]) == Late("beta", 9)


def test_one_machine_keeps_no_other_waiting() -> None:
    assert latecomer([(1, 5), (2, 9)], {1: "alpha", 2: "alpha"}) is None


def test_a_machine_without_a_name_is_not_late() -> None:
    assert latecomer([(1, 5), (7, 9)]) is None


def test_each_step_begins_anew() -> None:
    late = Latecomers(lambda: 0)
    late.hosts.update(HOSTS)
    late.came(1)
    assert late.ended() == late.ended()


@given(st.lists(st.tuples(st.integers(1, 4), st.integers(0, 10**10)), max_size=30))
def test_no_step_waits_longer_than_it_takes(arrivals: list[tuple[int, int]]) -> None:
    late = latecomer(arrivals)
    assert late is not None
    assert 0 <= late.by_ns <= sum(waits_ns for _, waits_ns in arrivals)
