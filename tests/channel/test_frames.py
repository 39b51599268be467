"""Frames have time on the air, loss, latency and outcome as their technology says."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.conditions import Conditions
from zenvoy.channel.frames import OnAir, Outcomes, outcomes_of
from zenvoy.channel.in_order import InOrder
from zenvoy.channel.pairs import Pairs, pairs
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import Channel, Fleet, Loss, Scenario, technologies

Floats = NDArray[np.float64]

MS_NS = 1_000_000
RING_M = 1_500.0
EVENLY = np.arange(39, -1, -1.0) * 37.5


@dataclass(frozen=True)
class Over:
    """A technology, and a scenario's settings of it."""

    technology: str
    loss: float = 0.0
    seed: int = 1
    mbps: float | None = None

    @property
    def medium(self) -> OnAir:
        channel = Channel(technology=technologies()[self.technology], bit_rate_mbps=self.mbps)
        return OnAir(technology=channel.radio, frame_bytes=300)

    def fates(
        self, reach: Pairs, position: Floats, *, sequence: int = 0, sent_ns: int = 0, wait_ns: int
    ) -> Outcomes:
        """Return the outcomes of frames of the whole fleet, in fresh conditions."""
        size = len(position)
        channel = Channel(technology=technologies()[self.technology], loss=Loss(p=self.loss))
        conditions = Conditions(Scenario(seed=self.seed, fleet=Fleet(size=size), channel=channel))
        numbers = np.full(len(reach.source), sequence)
        frames = SentFrames(reach.source, reach.destination, reach.distance, numbers)
        way = conditions.of(frames, Scene(sequence, sent_ns, position, RING_M))
        return outcomes_of(reach, way, sent_ns, sent_ns + wait_ns, self.medium, InOrder(size))


def send(
    over: Over, *, sequence: int = 0, sent_ns: int = 0, wait_ns: int = 11 * MS_NS
) -> tuple[Pairs, Outcomes]:
    reach = pairs(EVENLY, over.medium.technology.range_m, RING_M)
    fate = over.fates(reach, EVENLY, sequence=sequence, sent_ns=sent_ns, wait_ns=wait_ns)
    return reach, fate


@pytest.mark.parametrize(
    ("name", "mbps", "time_ns"),
    [
        ("ieee80211p", None, 400_000),  # 2400 bit at 6 Mbit/s
        ("ieee80211p", 27.0, 88_889),
        ("ieee80211px", None, 40_000),
        ("lte-a-pro", None, 800),
        ("5g-mmwave", None, 343),
    ],
)
def test_time_on_the_air(name: str, mbps: float | None, time_ns: int) -> None:
    assert Over(name, mbps=mbps).medium.frame_time_ns == time_ns


# Table I of the paper: range, delay from and to, broadcast.
TABLE: Final[dict[str, tuple[float, int, int, bool]]] = {
    "ieee80211p": (1_000.0, 10, 10, True),
    "ieee80211px": (1_000.0, 10, 10, True),
    "lte-a-pro": (30_000.0, 20, 80, True),
    "5g-mmwave": (50.0, 10, 10, False),
}


def test_technologies_have_the_values_of_table_1() -> None:
    assert {
        name: (of.range_m, *of.delay_ms, of.broadcast) for name, of in technologies().items()
    } == TABLE
    assert all(name == of.name for name, of in technologies().items())


@pytest.mark.parametrize("name", list(TABLE))
def test_latency_is_delay_and_time_on_the_air(name: str) -> None:
    over = Over(name)
    latencies = []
    for sequence in range(30):
        sent_ns = sequence * 100 * MS_NS
        _, fate = send(over, sequence=sequence, sent_ns=sent_ns)
        assert (fate.arrived_ns == sent_ns + fate.latency_ns).all()
        latencies.append(fate.latency_ns)
    latency_ns = np.concatenate(latencies)
    _, low_ms, high_ms, broadcast = TABLE[name]
    copies = 1 if broadcast else 2  # two neighbours within 50 m
    assert latency_ns.min() >= low_ms * MS_NS + over.medium.frame_time_ns
    assert latency_ns.max() <= high_ms * MS_NS + copies * over.medium.frame_time_ns
    if low_ms < high_ms:  # uniform between them: mean and extremes of thousands of draws
        share = (latency_ns - over.medium.frame_time_ns) / MS_NS / (high_ms - low_ms)
        share -= low_ms / (high_ms - low_ms)
        n = len(share)
        assert share.mean() == pytest.approx(0.5, abs=3.0 / math.sqrt(12 * n))
        assert share.var() == pytest.approx(1.0 / 12.0, rel=3.0 * math.sqrt(0.8 / n))
        assert share.min() < 20.0 / n
        assert share.max() > 1.0 - 20.0 / n


@pytest.mark.parametrize("loss", [0.0, 0.05, 0.3, 1.0])
def test_the_share_of_losses_is_that_of_the_setting(loss: float) -> None:
    """The limit is 2.58 standard deviations, which right draws exceed with probability 1 %."""
    over, lost, n = Over("ieee80211p", loss=loss), 0, 0
    for sequence in range(20):
        _, fate = send(over, sequence=sequence)
        gone = fate.outcome == pb.OUTCOME_LOST
        assert (fate.arrived_ns[gone] == -1).all()
        assert (fate.latency_ns[gone] == -1).all()
        assert (fate.outcome[~gone] == pb.OUTCOME_DELIVERED).all()
        lost, n = lost + int(gone.sum()), n + len(gone)
    assert abs(lost - n * loss) <= 2.58 * math.sqrt(n * loss * (1.0 - loss))


def test_each_frame_receiver_and_seed_has_its_own_draw() -> None:
    def outcomes(sequence: int, seed: int = 1) -> list[int]:
        _, fate = send(Over("ieee80211p", loss=0.5, seed=seed), sequence=sequence)
        outcome: list[int] = fate.outcome.tolist()
        return outcome

    assert outcomes(1) == outcomes(1)
    assert outcomes(1) != outcomes(2)
    assert outcomes(1) != outcomes(1, seed=2)
    reach, _ = send(Over("ieee80211p"))
    there = dict(
        zip(zip(reach.source.tolist(), reach.destination.tolist(), strict=True), outcomes(1),
            strict=True)
    )  # fmt: skip
    assert any(there[i, j] != there[j, i] for i, j in there)


def test_draws_do_not_depend_on_other_vehicles() -> None:
    over = Over("lte-a-pro", loss=0.5)
    few = pairs(EVENLY[:5], 30_000.0, None)
    some, alone = send(over)[1], over.fates(few, EVENLY[:5], wait_ns=11 * MS_NS)
    reach, _ = send(over)
    rows = (reach.source < 5) & (reach.destination < 5)
    np.testing.assert_array_equal(some.arrived_ns[rows], alone.arrived_ns)


def test_copies_go_out_one_by_one_to_the_nearest_receiver_first() -> None:
    """Distances are 10, 20 and 40 m. 5G mmWave has no broadcast and reaches 50 m."""
    over = Over("5g-mmwave", mbps=1.0)  # 2.4 ms a copy
    position = np.array([100.0, 90.0, 60.0, 50.0])
    reach = pairs(position, 50.0, None)
    fate = over.fates(reach, position, wait_ns=100 * MS_NS)
    latency_ms = {
        (int(i), int(j)): ns / MS_NS
        for i, j, ns in zip(reach.source, reach.destination, fate.latency_ns, strict=True)
    }
    assert latency_ms == {
        (0, 1): 12.4,
        (0, 2): 14.8,
        (0, 3): 17.2,
        (1, 0): 12.4,
        (1, 2): 14.8,
        (1, 3): 17.2,
        (2, 3): 12.4,
        (2, 1): 14.8,
        (2, 0): 17.2,
        (3, 2): 12.4,
        (3, 1): 14.8,
        (3, 0): 17.2,
    }


def test_a_receiver_out_of_range_gets_nothing() -> None:
    """A copy to a receiver out of range delays no other copy, and never arrives."""
    over = Over("5g-mmwave", mbps=1.0)
    position = np.array([200.0, 140.0, 100.0])
    reach = pairs(position, 50.0, None)
    fate = over.fates(reach, position, wait_ns=100 * MS_NS)
    rows = list(zip(reach.source.tolist(), reach.destination.tolist(), strict=True))
    assert rows == [(0, 1), (1, 0), (1, 2), (2, 1)]
    assert fate.outcome.tolist() == [
        pb.OUTCOME_OUT_OF_RANGE,
        pb.OUTCOME_OUT_OF_RANGE,
        pb.OUTCOME_DELIVERED,
        pb.OUTCOME_DELIVERED,
    ]
    assert fate.latency_ns.tolist() == [-1, -1, 12_400_000, 12_400_000]
    assert fate.arrived_ns.tolist() == [-1, -1, 12_400_000, 12_400_000]


def test_a_frame_after_the_deadline_is_late() -> None:
    over = Over("ieee80211p")
    for wait_ns, outcome in (
        (10_400_000, pb.OUTCOME_DELIVERED),
        (10_399_999, pb.OUTCOME_LATE),
        (0, pb.OUTCOME_LATE),
    ):
        _, fate = send(over, wait_ns=wait_ns)
        assert (fate.outcome == outcome).all()
        assert (fate.latency_ns == 10_400_000).all()
