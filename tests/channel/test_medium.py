"""The medium has carrier sense, collisions, a busy ratio and congestion control."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from zenvoy.channel.access import busy_ratio, collided
from zenvoy.channel.csma import SLOT_NS, Backoffs, Hearing, aifs_ns, airtime_ns, contend
from zenvoy.links.sent_frames import SentFrames

Ints = NDArray[np.int64]

AIR: Final = airtime_ns(300, 6.0)
SPACE: Final = aifs_ns(6)
PERIOD: Final = 100_000_000


@pytest.mark.parametrize(
    ("frame_bytes", "rate", "symbols"),
    [(300, 6.0, 51), (300, 3.0, 101), (300, 27.0, 12), (1, 6.0, 1), (400, 6.0, 68)],
)
def test_airtime_is_of_whole_symbols(frame_bytes: int, rate: float, symbols: int) -> None:
    """16 + 8 · bytes + 6 bits go in symbols of 24 bits at 3 Mbit/s, 48 at 6, 216 at 27."""
    assert airtime_ns(frame_bytes, rate) == 40_000 + 8_000 * symbols


def test_aifs_is_that_of_the_standard() -> None:
    assert SPACE == 32_000 + 6 * 13_000


def hearing(senses: NDArray[np.bool_]) -> Hearing:
    """Return who hears whom, where senses[i, j] says that j senses i."""
    first = np.concatenate([[0], np.cumsum(senses.sum(axis=1))])
    return Hearing(first, np.flatnonzero(senses.ravel()) % len(senses))


def everyone(n: int) -> NDArray[np.bool_]:
    return ~np.eye(n, dtype=bool)


def starts(ready_ns: Ints, senses: NDArray[np.bool_], seed: int = 1, window: int = 15) -> Ints:
    n = len(ready_ns)
    numbers, idle = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    backoffs = Backoffs(seed, window)
    return contend(ready_ns, numbers, hearing(senses), idle, AIR, SPACE, PERIOD, backoffs)


def test_a_lone_station_waits_for_aifs() -> None:
    assert starts(np.array([5_000_000, -1]), everyone(2)).tolist() == [5_000_000 + SPACE, -1]


def test_a_station_that_senses_another_waits_for_its_end_and_a_backoff() -> None:
    first, second = starts(np.array([0, 200_000]), everyone(2)).tolist()
    end = first + AIR
    slots, rest = divmod(second - end - SPACE, SLOT_NS)
    assert rest == 0
    assert 0 <= slots <= 15
    assert slots == Backoffs(1, 15).slots(1, 0, 0)


def test_a_station_that_senses_nobody_does_not_wait() -> None:
    alone = np.zeros((2, 2), dtype=bool)
    assert starts(np.array([0, 200_000]), alone).tolist() == [SPACE, 200_000 + SPACE]


networks = st.integers(2, 12).flatmap(
    lambda n: st.tuples(
        st.lists(st.integers(-1, 3_000_000), min_size=n, max_size=n),
        st.lists(st.booleans(), min_size=n * (n - 1) // 2, max_size=n * (n - 1) // 2),
    )
)


def network(ready: list[int], edges: list[bool]) -> tuple[Ints, NDArray[np.bool_]]:
    n = len(ready)
    senses = np.zeros((n, n), dtype=bool)
    senses[np.triu_indices(n, 1)] = edges
    return np.array(ready, dtype=np.int64), senses | senses.T


@pytest.mark.parametrize("patience_ns", [AIR // 2, 3 * AIR])
def test_a_station_that_finds_no_time_gives_up(patience_ns: int) -> None:
    ready_ns, idle = np.array([0, 200_000]), np.zeros(2, dtype=np.int64)
    numbers, backoffs = np.zeros(2, dtype=np.int64), Backoffs(1, 15)
    heard = hearing(everyone(2))
    first, second = contend(
        ready_ns, numbers, heard, idle, AIR, SPACE, patience_ns, backoffs
    ).tolist()
    assert first == SPACE
    assert (second < 0) == (patience_ns < AIR)
    frames = SentFrames(np.array([1]), np.array([0]), np.zeros(1), np.zeros(1, dtype=np.int64))
    gave_up = collided(frames, np.array([first, second]), heard, AIR)
    assert gave_up.tolist() == [patience_ns < AIR]


@given(networks)
def test_no_station_begins_while_it_senses_another(drawn: tuple[list[int], list[bool]]) -> None:
    ready, senses = network(*drawn)
    began = starts(ready, senses)
    assert ((began >= ready + SPACE) | (ready < 0)).all()
    assert ((began < 0) == (ready < 0)).all()
    for i, j in np.argwhere(senses):
        if began[i] >= 0 and began[i] + SLOT_NS <= began[j]:  # i is on the air, and sensed
            assert began[j] >= began[i] + AIR


def one_by_one(frames: SentFrames, began: Ints, senses: NDArray[np.bool_]) -> Iterator[bool]:
    for source, receiver in zip(frames.source.tolist(), frames.destination.tolist(), strict=True):
        overlapping = [
            other
            for other in range(len(began))
            if other != source and began[other] >= 0 and abs(began[other] - began[source]) < AIR
        ]
        yield any(other == receiver or senses[other, receiver] for other in overlapping)


@given(networks)
def test_collisions_agree_with_a_check_one_by_one(drawn: tuple[list[int], list[bool]]) -> None:
    began, senses = network(*drawn)  # any starts, even those that carrier sense forbids
    pairs = np.argwhere(senses & (began >= 0)[:, None])
    source, destination = pairs.T
    frames = SentFrames(
        source, destination, np.zeros(len(source)), np.zeros(len(source), dtype=np.int64)
    )
    found = collided(frames, began, hearing(senses), AIR)
    assert found.tolist() == list(one_by_one(frames, began, senses))


@given(networks)
def test_the_busy_ratio_agrees_with_a_sum_one_by_one(drawn: tuple[list[int], list[bool]]) -> None:
    began, senses = network(*drawn)
    found = busy_ratio(began, hearing(senses), AIR, PERIOD)
    for station in range(len(began)):
        mine = began[(senses[:, station] | (np.arange(len(began)) == station)) & (began >= 0)]
        busy, end = 0, -1
        for start in sorted(mine.tolist()):
            busy += start + AIR - max(start, end)
            end = start + AIR
        assert found[station] == pytest.approx(busy / PERIOD, rel=1e-12)


def test_backoffs_are_uniform_and_independent() -> None:
    backoffs = Backoffs(1, 15)
    drawn = [backoffs.slots(s, q, t) for s in range(20) for q in range(50) for t in range(10)]
    assert stats.chisquare(np.bincount(drawn, minlength=16)).pvalue > 0.01
    assert max(drawn) == 15
    assert Backoffs(1, 15).slots(3, 7, 9) == backoffs.slots(3, 7, 9)
    assert [Backoffs(2, 15).slots(0, q, 0) for q in range(20)] != [
        backoffs.slots(0, q, 0) for q in range(20)
    ]
