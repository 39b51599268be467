"""The pace of a run names the machine that has cost the most time, if that is much."""

from __future__ import annotations

import pytest

from zenvoy.bus.latecomers import Late
from zenvoy.world.pace import HeldUp, Pace

MS = 1_000_000


@pytest.mark.parametrize(("together", "by_ns"), [(True, 8 * MS), (False, 13 * MS)])
def test_waits_in_world_and_channel_overlap_only_if_the_world_runs_ahead(
    together: bool, by_ns: int
) -> None:
    pace = Pace(together=together)
    for _ in range(3):
        pace.add((Late("beta", 5 * MS), Late("beta", 8 * MS)))
    pace.add((Late("alpha", 2 * MS), None))
    assert pace.slowest(60 * MS) == HeldUp("beta", 0.75, by_ns)


def test_a_long_wait_counts_as_much_as_many_short_ones() -> None:
    pace = Pace(together=True)
    for step in range(100):
        pace.add((Late("alpha", 5 * MS), Late("beta", 600 * MS if step == 50 else 0)))
    assert pace.slowest(1_500 * MS) == HeldUp("beta", 0.01, 600 * MS)


def test_in_an_ordinary_run_nobody_is_named() -> None:
    pace = Pace(together=True)
    assert pace.slowest(0) is None
    for step in range(100):  # of 10 ms each; those below 1 ms do not count at all
        pace.add((Late("alpha" if step % 3 else "beta", MS - 1), Late("beta", MS)))
    assert pace.slowest(1_000 * MS) is None


def test_a_machine_without_a_name_is_left_out() -> None:
    pace = Pace(together=True)
    pace.add((Late("", 500 * MS), None))
    assert pace.slowest(600 * MS) is None
