"""Vehicles relay frames, so that controllers reach beyond the range."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.logs import write_log
from zenvoy.analysis import load as load_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.relay import Hop, relay

Ints = NDArray[np.int64]

NEVER = 10**9


def hop(links: dict[tuple[int, int], int]) -> Hop:
    """Return a hop over links (source, destination), with latencies, or -1 where lost."""
    ends = sorted(links)
    source, destination = np.array(ends, dtype=np.int64).reshape(-1, 2).T
    return Hop(source, destination, np.array([links[end] for end in ends], dtype=np.int64))


def reached(
    links: dict[tuple[int, int], int], size: int, most: int
) -> dict[tuple[int, int], tuple[int, int]]:
    found = relay(hop(links), size, most)
    columns = (found.source, found.destination, found.latency_ns, found.hops)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return {(source, destination): (latency, hops) for source, destination, latency, hops in rows}


LINE = {(i, j): 10 + i for i in range(5) for j in (i - 1, i + 1) if 0 <= j < 5}


def test_latencies_add_up_along_a_line() -> None:
    assert reached(LINE, 5, 1) == {}
    two = reached(LINE, 5, 2)
    assert two[0, 2] == (10 + 11, 2)
    assert two[4, 2] == (14 + 13, 2)
    assert set(two) == {(i, j) for i in range(5) for j in range(5) if abs(i - j) == 2}
    all_of_it = reached(LINE, 5, 9)
    assert all_of_it[0, 4] == (10 + 11 + 12 + 13, 4)
    assert set(all_of_it) == {(i, j) for i in range(5) for j in range(5) if abs(i - j) >= 2}


def test_a_lost_frame_is_not_relayed() -> None:
    lost = LINE | {(1, 2): -1}
    found = reached(lost, 5, 9)
    assert found[0, 2] == (-1, 2)
    assert found[0, 4] == (-1, 4)
    assert found[4, 0][0] > 0


def test_the_fastest_of_several_paths_counts() -> None:
    links = {(0, 1): 10, (0, 2): 30, (1, 3): 50, (2, 3): 20}
    assert reached(links, 4, 2) == {(0, 3): (50, 2)}
    assert reached(links | {(2, 3): -1}, 4, 2) == {(0, 3): (60, 2)}
    assert reached(links | {(2, 3): -1, (0, 1): -1}, 4, 2) == {(0, 3): (-1, 2)}


def test_relays_reach_neither_the_source_nor_a_vehicle_that_hears_it_already() -> None:
    links = {(0, 1): 1, (1, 0): 1, (1, 2): 1, (0, 2): 9}
    assert reached(links, 3, 5) == {}


networks = st.integers(2, 6).flatmap(
    lambda n: st.tuples(
        st.just(n),
        st.dictionaries(
            st.tuples(st.integers(0, n - 1), st.integers(0, n - 1)).filter(lambda e: e[0] != e[1]),
            st.integers(-1, 20),
            max_size=n * n,
        ),
        st.integers(1, 5),
    )
)


@given(networks)
def test_relayed_latencies_are_those_of_shortest_paths(
    drawn: tuple[int, dict[tuple[int, int], int], int],
) -> None:
    size, links, most = drawn
    expected = {}
    for source in range(size):
        depth, best, level = {source: 0}, {source: 0}, [source]
        for hops in range(1, most + 1):
            layer: dict[int, int] = {}
            for via in level:
                for (a, b), latency in links.items():
                    if a == via and b not in depth:
                        whole = NEVER if latency < 0 else min(NEVER, best[via] + latency)
                        layer[b] = min(layer.get(b, NEVER), whole)
            depth |= dict.fromkeys(layer, hops)
            best |= layer
            level = list(layer)
            if hops > 1:
                for there, latency in layer.items():
                    expected[source, there] = (-1 if latency == NEVER else latency, hops)
    assert reached(links, size, most) == expected


MMWAVE = """
duration_s: 4
fleet: {{size: 9}}
control: {{model: MBCM, v2v_wait_ms: 35}}
channel: {{technology: 5g-mmwave, relay_hops: {hops}}}
"""


def test_multi_node_control_reaches_beyond_the_range(tmp_path: Path) -> None:
    """5G mmWave reaches 50 m: one vehicle each way at 37.5 m, and three with three hops."""
    alone, passed_on = (
        load_log(write_log(tmp_path / f"{hops}.mcap", MMWAVE.format(hops=hops))) for hops in (1, 3)
    )
    assert (alone.estimate["neighbours"][5:] == 1).all()
    assert (passed_on.estimate["neighbours"][5:] == 3).all()
    frames = passed_on.frames
    assert set(np.unique(frames["outcome"]).tolist()) == {pb.OUTCOME_DELIVERED}
    apart = np.abs(frames["source"].astype(int) - frames["destination"])
    apart = np.minimum(apart, 9 - apart)
    hop_ms = frames["latency_ns"] * 1e-6 / apart
    assert (hop_ms >= 10.0).all()  # delay and time on the air, hop by hop
    assert (hop_ms < 10.01).all()
    assert np.bincount(apart).tolist() == [0, 18 * 40, 18 * 40, 18 * 40]


def test_losses_reduce_what_is_relayed(tmp_path: Path) -> None:
    text = MMWAVE.format(hops=3).replace("relay_hops", "loss: {p: 0.2}, relay_hops")
    frames = load_log(write_log(tmp_path / "run.mcap", text)).frames
    apart = np.abs(frames["source"].astype(int) - frames["destination"])
    apart = np.minimum(apart, 9 - apart)
    for hops in (1, 2, 3):
        through = frames["outcome"][apart == hops] == pb.OUTCOME_DELIVERED
        p = 0.8**hops
        assert abs(through.mean() - p) < 2.6 * np.sqrt(p * (1.0 - p) / len(through) * 3)
