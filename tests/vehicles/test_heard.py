"""A vehicle copes with beacons that are late, doubled, out of order, or senseless."""

from __future__ import annotations

import math

import pytest

from tests.cab import AHEAD, BEHIND, STILL, T_NS, Cab, beacon, scenario
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Gains


def test_reordering_duplicates_and_strangers_change_nothing() -> None:
    """One vehicle gets beacons in order, the other with all that a channel may add to them."""
    orderly, other = Cab(scenario()), Cab(scenario())
    fronts = [
        beacon(AHEAD, k, speed=30.0 - 0.1 * k, acceleration=-1.0 + 0.1 * k) for k in range(12)
    ]
    rears = [
        beacon(BEHIND, k, gap=36.0 + 0.2 * k, relative_speed=0.3, acceleration=0.1 * k)
        for k in range(12)
    ]
    strangers = [beacon(1 + 4 * (k % 2), k // 2, gap=6.0, acceleration=3.0) for k in range(24)]
    for k in range(12):
        for cab in (orderly, other):
            cab.sense(gap=37.0 + 0.1 * k, speed=30.0, acceleration=0.0)
        news: list[pb.Beacon] = []  # no frame arrives in every third cycle
        if k % 3 == 1:
            news = [*fronts[max(0, k - 1) : k + 1], *rears[max(0, k - 1) : k + 1]]
        elif k % 3 == 2:
            news = [fronts[k], rears[k]]
        replayed = [*fronts[: max(0, k - 2)], *rears[: max(0, k - 2)]]
        decided = orderly.receive(news)
        mixed_up = other.receive([*news[::-1], *replayed, *strangers[: 2 * k], *news])
        assert mixed_up.SerializeToString() == decided.SerializeToString()
        if k > 0:
            assert decided.behind.measured_ns == (k if k % 3 else k - 1) * T_NS


def senseless() -> list[pb.Beacon]:
    """Return beacons that no correct vehicle behind sends."""
    later = beacon(BEHIND, 50)
    torn = beacon(BEHIND, 2)
    torn.planned_from_ns.append(7 * T_NS)
    numbers = [
        beacon(BEHIND, 2, gap=math.nan),
        beacon(BEHIND, 2, relative_speed=math.inf),
        beacon(BEHIND, 2, speed=-math.inf),
        beacon(BEHIND, 2, acceleration=math.nan),
    ]
    return [later, torn, *numbers]


@pytest.mark.parametrize("nonsense", senseless())
def test_a_beacon_that_makes_no_sense_counts_as_lost(nonsense: pb.Beacon) -> None:
    deaf, other = Cab(scenario()), Cab(scenario())
    for k in range(5):
        news = [] if k == 2 else [beacon(AHEAD, k), beacon(BEHIND, k, gap=36.0)]
        for cab in (deaf, other):
            cab.sense()
        wrong = [nonsense] if k == 2 else []
        assert other.receive([*news, *wrong]) == deaf.receive(news)


def test_a_late_frame_counts_at_its_own_time() -> None:
    cab = Cab(scenario(gains=STILL))
    for k in range(3):
        cab.sense()
        cab.receive([beacon(BEHIND, k)])
    cab.sense()
    assert cab.receive().behind.measured_ns == 2 * T_NS
    cab.sense()
    # It was sent in cycle 3, when the gap was 50 m and grew by 10 m/s. The prediction spans 0.2 s.
    late = cab.receive([beacon(BEHIND, 3, gap=50.0, relative_speed=10.0)])
    assert late.behind.measured_ns == 3 * T_NS
    assert late.age_ns == T_NS
    v = late.behind.speed
    assert late.behind.predicted_gap == pytest.approx(late.behind.gap + 0.2 * v, abs=1e-9)
    assert v > 8.0


def test_bcm_uses_the_newest_reading_of_a_neighbour() -> None:
    cab = Cab(scenario(model="BCM", gains=Gains(k_d=0.1, k_v=0.0, k_c=0.0)))
    cab.sense(gap=40.0)
    cab.receive([beacon(BEHIND, 0, gap=30.0)])
    cab.sense(gap=40.0)
    command = cab.receive([beacon(BEHIND, 1, gap=35.0), beacon(BEHIND, 0, gap=20.0)])
    assert command.acceleration == pytest.approx(0.5)  # 0.1 · (40 - 35)
    assert command.mode == pb.MODE_BCM
    assert math.isnan(command.ahead.gap)
    assert math.isnan(command.predicted_speed)
