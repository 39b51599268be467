"""`Arrivals` wakes its reader for items that must wake it, and loses none of the others."""

from __future__ import annotations

import threading
from queue import Empty

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.arrivals import Arrivals
from zenvoy.bus.clock import wall_ns

FAR_NS = 3_600_000_000_000


def soon() -> int:
    return wall_ns() + 1_000_000


def test_get_raises_empty_at_the_deadline() -> None:
    with pytest.raises(Empty):
        Arrivals[int]().get(soon())
    with pytest.raises(Empty):
        Arrivals[int]().get(0)


def test_items_that_do_not_wake_are_there_at_the_deadline() -> None:
    arrivals = Arrivals[int]()
    arrivals.put_without_waking(1)
    arrivals.put_without_waking(2)
    assert [arrivals.get(soon()), arrivals.get(soon())] == [1, 2]
    with pytest.raises(Empty):
        arrivals.get(soon())


def test_one_waking_item_or_many_silent_ones_wake_the_reader() -> None:
    arrivals = Arrivals[str]()
    for number in range(7):
        arrivals.put_without_waking(f"silent {number}")
    arrivals.put("waking")
    assert arrivals.get(wall_ns() + FAR_NS) == "waking"  # nobody waits for the deadline
    arrivals.put_without_waking("silent 7")
    received = [arrivals.get(wall_ns() + FAR_NS) for _ in range(8)]
    assert received == [f"silent {number}" for number in range(8)]
    assert len(arrivals) == 0


def test_a_reader_in_another_thread_is_woken() -> None:
    arrivals = Arrivals[int]()
    writer = threading.Thread(target=arrivals.put, args=(5,))
    writer.start()
    assert arrivals.get(wall_ns() + FAR_NS) == 5
    writer.join()


@given(st.lists(st.booleans(), max_size=60))
def test_no_item_is_lost_or_doubled_and_each_kind_keeps_its_order(waking: list[bool]) -> None:
    arrivals = Arrivals[tuple[bool, int]]()
    for number, wakes in enumerate(waking):
        (arrivals.put if wakes else arrivals.put_without_waking)((wakes, number))
    received: list[tuple[bool, int]] = []
    while True:
        try:
            received.append(arrivals.get(0))
        except Empty:
            break
    for kind in (True, False):
        wanted = [number for number, wakes in enumerate(waking) if wakes == kind]
        assert [number for wakes, number in received if wakes == kind] == wanted
    assert len(received) == len(waking)
