"""A program that joins finds the runs there are at its endpoints."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh

from zenvoy.bus.clock import wall_ns
from zenvoy.bus.errors import SeveralRunsError
from zenvoy.bus.querying import answer
from zenvoy.bus.runs import offer_about, the_run
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import about_key
from zenvoy.bus.vehicle_processes import vehicle_processes

SHARED = vehicle_processes(3, 2)[:1]


@pytest.fixture
def sessions(tmp_path: Path) -> Iterator[tuple[zenoh.Session, zenoh.Session]]:
    """Yield a session that worlds share, as through a router, and one that asks."""
    endpoint = f"unixsock-stream/{tmp_path / 'world'}"
    with open_session([endpoint], []) as worlds, open_session([], [endpoint]) as asks:
        yield worlds, asks


def test_the_only_run_is_found(sessions: tuple[zenoh.Session, zenoh.Session]) -> None:
    worlds, asks = sessions
    _ = offer_about(worlds, "one", 3, SHARED, set())
    assert the_run(asks, _deadline_ns(60)) == "one"


def test_several_runs_are_listed(sessions: tuple[zenoh.Session, zenoh.Session]) -> None:
    worlds, asks = sessions
    _ = (
        offer_about(worlds, "one", 3, SHARED, {"vehicles-01-02", "world"}),
        offer_about(worlds, "two", 20, (), {"vehicle-07"}),
        answer(worlds, about_key("odd"), lambda: b"[]"),  # what is no answer of a world
    )
    text = r"there are 2 runs, with .*: one \(2 of 3 vehicles\), two \(1 of 20 vehicles\)"
    with pytest.raises(SeveralRunsError, match=text):
        the_run(asks, _deadline_ns(60))


def test_no_run_is_found_where_nobody_answers(
    sessions: tuple[zenoh.Session, zenoh.Session],
) -> None:
    assert the_run(sessions[1], _deadline_ns(0)) is None


def _deadline_ns(limit_s: int) -> int:
    return wall_ns() + limit_s * 1_000_000_000
