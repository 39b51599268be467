"""The tables of regulated drive cycles add up to the known figures, and a platoon follows them."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
import pytest

from tests.scenarios.test_library import run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import EVENTS, TRUTH
from zenvoy.scenarios import Trace, load

MILE_M: Final = 1609.344
KMH: Final = 1 / 3.6
MPH: Final = 0.44704
UDDS_S: Final = 1_369.0
Points = tuple[tuple[float, float], ...]


def cycle(name: str) -> Points:
    (event,) = load(f"lead/{name}").scenario.events
    assert isinstance(event, Trace)
    assert (event.vehicle, event.at_s, event.points[0]) == (1, 0.0, (0.0, 0.0))
    return event.points


def distance_m(points: Points) -> float:
    return sum((t1 - t0) * (v0 + v1) / 2 for (t0, v0), (t1, v1) in pairwise(points))


def top_mps(points: Points) -> float:
    return max(speed for _, speed in points)


def test_wltc_class_3b_is_that_of_gtr_15() -> None:
    """UN GTR No. 15, Annex 1 has 23.266 km in 1800 s: 3.095, 4.756, 7.162 and 8.254 km."""
    points = cycle("wltp")
    assert [time for time, _ in points] == list(range(1_801))
    assert distance_m(points) == pytest.approx(23_266.3, abs=0.1)
    assert top_mps(points) == pytest.approx(131.3 * KMH, abs=1e-12)
    parts = [points[a : b + 1] for a, b in pairwise((0, 589, 1_022, 1_477, 1_800))]
    assert [round(distance_m(part)) for part in parts] == [3_095, 4_756, 7_162, 8_254]
    tops = [top_mps(part) for part in parts]
    assert tops == pytest.approx([v * KMH for v in (56.5, 76.6, 97.4, 131.3)], abs=1e-12)
    assert all(part[0][1] == part[-1][1] == 0.0 for part in parts)


def test_ftp_75_is_the_udds_a_soak_and_its_first_505_seconds() -> None:
    """40 CFR 86, Appendix I (a) has 7.45 miles in 1369 s, up to 56.7 mph; 11.04 miles in all."""
    points = cycle("ftp-75")
    udds = tuple(point for point in points if point[0] <= UDDS_S)
    assert [time for time, _ in udds] == list(range(1_370))
    assert distance_m(udds) / MILE_M == pytest.approx(7.45, abs=0.005)
    assert distance_m(udds) == pytest.approx(11_990, abs=1.0)
    assert top_mps(udds) == pytest.approx(56.7 * MPH, abs=1e-12)
    hot = tuple((time - 1_969.0, speed) for time, speed in points if time > UDDS_S)
    assert hot == udds[:506]
    assert udds[-1][1] == hot[0][1] == 0.0  # so it stands for ten minutes
    assert distance_m(points) / MILE_M == pytest.approx(11.04, abs=0.005)


def test_us06_is_that_of_the_supplemental_procedure() -> None:
    """40 CFR Part 86, Appendix I (g) has 8.01 miles, up to 80.3 mph."""
    points = cycle("us06")
    assert [time for time, _ in points] == list(range(601))
    assert distance_m(points) / MILE_M == pytest.approx(8.01, abs=0.005)
    assert top_mps(points) == pytest.approx(80.3 * MPH, abs=1e-12)
    steepest = max(b - a for (_, a), (_, b) in pairwise(points))
    assert steepest == pytest.approx(8.4 * MPH, abs=1e-9)
    assert load("lead/us06").scenario.control.acceleration_limit_mps2 > steepest


@pytest.mark.parametrize("name", ["wltp", "ftp-75", "us06"])
def test_a_platoon_follows_from_rest(name: str) -> None:
    """In the first half minute all vehicles stand, then drive. None collides or falls behind."""
    scenario = load(f"lead/{name}", duration_s=30.0).scenario
    log = run(scenario)
    truth = [pb.FleetTruth.FromString(data) for data in log[TRUTH]]
    speed, position = (
        np.array([getattr(row, of) for row in truth]) for of in ("speed", "position")
    )
    assert speed[0].max() == 0.0
    assert speed[-1].min() > 5.0
    points = np.array(cycle(name))
    assert speed[::10, 0] == pytest.approx(points[:31, 1], abs=1e-9)
    gaps = -np.diff(position, axis=1)
    assert 13.0 < gaps.min() < gaps.max() < 17.0
    kinds = {pb.Event.FromString(data).kind for data in log[EVENTS]}
    assert kinds == {pb.EVENT_TRACE}
