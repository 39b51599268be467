"""The medium has carrier sense, collisions, a busy ratio and congestion control."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from tests.logs import write_log
from tests.refused import refused
from zenvoy.analysis import load as load_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.access import busy_ratio, collided
from zenvoy.channel.congestion import ReactiveDcc
from zenvoy.channel.csma import SLOT_NS, Backoffs, Hearing, aifs_ns, airtime_ns, contend
from zenvoy.channel.rehearsal import rehearse
from zenvoy.links.sent_frames import SentFrames
from zenvoy.scenarios import Channel, Fleet, Medium, Road, Scenario

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


def scenario(size: int, cycles: int = 20, gap_m: float = 10.0, **medium: Any) -> Scenario:
    return Scenario(
        duration_s=cycles * 0.1,
        road=Road(type="open"),
        fleet=Fleet(size=size, gap_m=gap_m),
        channel=Channel(medium=Medium(access="csma", **medium)),
    )


def rehearsed(of: Scenario) -> dict[str, NDArray[Any]]:
    tables = list(rehearse(of))
    names = ("source", "sequence", "latency_ns", "outcome")
    columns = {name: np.concatenate([table[name] for table in tables]) for name in names}
    return columns | {"busy_ratio": np.array([table["busy_ratio"] for table in tables])}


def test_access_delay_grows_with_load() -> None:
    """The mean wait beyond AIFS rises with load, at least as in an M/D/1 queue."""
    waits = []
    for size in (2, 20, 60, 90):
        table = rehearsed(scenario(size))
        latency_ns = table["latency_ns"][table["latency_ns"] >= 0]
        assert latency_ns.min() >= 10_000_000 + SPACE + AIR
        waits.append(float(latency_ns.mean()) - 10_000_000 - SPACE - AIR)
        load = size * AIR / PERIOD
        assert table["busy_ratio"][:, size // 2].mean() == pytest.approx(load, rel=0.03)
    assert waits[0] < 0.02 * AIR
    assert waits[0] < waits[1] < waits[2] < waits[3]
    rho = 20 * AIR / PERIOD  # waiting of an M/D/1 queue, without the backoffs
    assert waits[1] > 0.5 * AIR * rho / (1.0 - rho) * 0.9


def test_hidden_stations_collide_where_others_hear_both() -> None:
    """In a line of 1 km frames collide if sensed over 100 m, and rarely if sensed over 1 km."""
    shares = []
    for sense_m in (100.0, 2_000.0):
        outcome = rehearsed(scenario(100, carrier_sense_m=sense_m))["outcome"]
        shares.append(float((outcome == pb.OUTCOME_COLLIDED).mean()))
    assert shares[1] < 0.1
    assert shares[0] < 1.0
    assert rehearsed(scenario(40))["outcome"].max() == pb.OUTCOME_COLLIDED


def test_congestion_control_follows_the_table() -> None:
    dcc, everyone_speaks = ReactiveDcc(1), np.array([True])
    for ratio, off_ms in [
        (0.0, 100),
        (0.3, 200),
        (0.45, 400),
        (0.55, 500),
        (0.6, 1_000),
        (0.2, 100),
    ]:
        dcc.sensed(np.array([ratio]))
        sent = []
        for ms in range(0, 4_000, 100):
            if dcc.allowed(everyone_speaks, (10_000 + ms) * 1_000_000)[0]:
                sent.append(ms)
        gaps = set(np.diff(sent).tolist())
        assert gaps == {off_ms}
        dcc = ReactiveDcc(1)


def test_congestion_control_counts_from_the_last_frame() -> None:
    dcc, speaks = ReactiveDcc(1), np.array([True])
    assert dcc.allowed(speaks, 0)[0]
    dcc.sensed(np.array([0.7]))
    assert not dcc.allowed(speaks, 900_000_000)[0]
    assert dcc.allowed(speaks, 1_000_000_000)[0]


def test_congestion_control_keeps_the_medium_usable() -> None:
    free = rehearsed(scenario(250, gap_m=6.0))
    ruled = rehearsed(scenario(250, gap_m=6.0, congestion_control="reactive"))
    assert free["busy_ratio"].mean() > 0.65
    assert free["latency_ns"].max() < 10_000_000 + PERIOD + AIR  # no frame waits for ever
    assert ruled["busy_ratio"][5:].mean() < 0.5
    assert len(ruled["source"]) < 0.6 * len(free["source"])


@settings(max_examples=5)
@given(st.integers(0, 2**40))
def test_the_same_seed_gives_the_same_frames(seed: int) -> None:
    of = scenario(15, cycles=5).model_copy(update={"seed": seed})
    first, again = rehearsed(of), rehearsed(of)
    for name, column in first.items():
        np.testing.assert_array_equal(column, again[name])


def test_the_log_has_the_busy_ratio(tmp_path: Path) -> None:
    text = "{duration_s: 2, fleet: {size: 5}, channel: {medium: {access: csma}}}"
    run = load_log(write_log(tmp_path / "run.mcap", text))
    assert run.busy_ratio.shape == (20, 5)
    assert run.busy_ratio.mean() == pytest.approx(5 * AIR / PERIOD, rel=1e-3)
    plain = load_log(write_log(tmp_path / "plain.mcap", "{duration_s: 1, fleet: {size: 5}}"))
    assert plain.busy_ratio.shape == (0, 5)


@pytest.mark.parametrize(
    ("channel", "line"),
    [
        (
            "{technology: lte-a-pro, medium: {access: csma}}",
            "channel.medium.access: csma is not possible with lte-a-pro; allowed: none, or "
            "csma with ieee80211p, ieee80211px, or with a technology that has csma: true",
        ),
        (
            "{medium: {congestion_control: reactive}}",
            "channel.medium.congestion_control: reactive needs csma as channel.medium.access",
        ),
        ("{medium: {aifsn: 1}}", "channel.medium.aifsn: 1 is not in [2, 15]"),
    ],
)
def test_wrong_settings_are_refused(tmp_path: Path, channel: str, line: str) -> None:
    (found,) = refused(tmp_path, f"channel: {channel}\n")
    assert found.startswith(line)
