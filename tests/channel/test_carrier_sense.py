"""Fleets whose stations sense each other: load, collisions, congestion control, the log."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.logs import write_log
from tests.refused import refused
from zenvoy.analysis import load as load_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.congestion import ReactiveDcc
from zenvoy.channel.csma import aifs_ns, airtime_ns
from zenvoy.channel.rehearsal import rehearse
from zenvoy.scenarios import Channel, Fleet, Medium, Road, Scenario

AIR: Final = airtime_ns(300, 6.0)
SPACE: Final = aifs_ns(6)
PERIOD: Final = 100_000_000


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
