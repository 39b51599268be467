"""Loss follows from received power: path loss, vehicles in the way, shadowing and fading."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from zenvoy.channel.conditions import Conditions
from zenvoy.keyed_random.draws import Draws, Seeds, numbered
from zenvoy.links.loss.path_loss import LOSS, between, outage, path_loss_db
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.links.shadowing import Shadowing
from zenvoy.scenarios import Channel, Fleet, Loss, PathLoss, Scenario

Floats = NDArray[np.float64]

PLAIN: Final = PathLoss(shadowing_db=0.0, blockage_db=0.0)


def all_frames(position: Floats, ring_length_m: float | None, sequence: int = 0) -> SentFrames:
    n = len(position)
    source, destination = (i[~np.eye(n, dtype=bool)] for i in np.indices((n, n), dtype=np.int64))
    distance = np.abs(position[source] - position[destination])
    if ring_length_m is not None:
        distance = np.mod(distance, ring_length_m)
        distance = np.minimum(distance, ring_length_m - distance)
    return SentFrames(source, destination, distance, np.full(len(source), sequence))


def test_two_slopes_by_hand() -> None:
    found = path_loss_db(np.array([1.0, 10.0, 104.0, 1040.0]), PLAIN)
    near = 66.1 + 16.6 * np.log10(10.4)
    assert found.tolist() == pytest.approx([66.1, 66.1, near, near + 28.8], rel=1e-12)


@given(st.floats(0, 1e4), st.floats(0, 1e4))
def test_received_power_never_rises_with_distance(a: float, b: float) -> None:
    near, far = sorted((a, b))
    low, high = path_loss_db(np.array([near, far]), PLAIN).tolist()
    assert low <= high


def test_without_fading_there_is_a_threshold() -> None:
    assert outage(np.array([-0.1, 0.0, 0.1]), None).tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("m", [0.7, 1.0, 3.0])
def test_fading_has_nakagamis_distribution(m: float) -> None:
    margin_db = np.linspace(-15.0, 25.0, 9)
    amplitude = 10.0 ** (-margin_db / 20.0)  # the one needed, over the root of the mean power
    np.testing.assert_allclose(outage(margin_db, m), stats.nakagami(m).cdf(amplitude), rtol=1e-9)


def test_rayleigh_fading_has_exponential_power() -> None:
    assert outage(np.array([10.0]), 1.0)[0] == pytest.approx(1.0 - np.exp(-0.1), rel=1e-12)


@given(
    st.lists(st.integers(0, 1_000_000), min_size=2, max_size=9, unique=True),
    st.booleans(),
    st.integers(-3, 3),
)
def test_vehicles_between_are_counted(places: list[int], ring: bool, laps: int) -> None:
    """The reference counts them one by one."""
    length_m = 1_000.001 if ring else None
    position = np.array(places) / 1_000.0
    position[0] += laps * (length_m or 0.0)
    frames, scene = all_frames(position, length_m), Scene(0, 0, position, length_m)
    for source, destination, found in zip(
        frames.source, frames.destination, between(frames, scene), strict=True
    ):
        at = position if length_m is None else np.mod(position, length_m)
        if length_m is None:
            low, high = sorted((at[source], at[destination]))
            counted = int(((at > low) & (at < high)).sum())
        else:
            forward = np.mod(at - at[destination], length_m)
            there = forward[source]
            others = np.delete(forward, [source, destination])
            ahead = int((others < there).sum())
            counted = ahead if there <= length_m - there else len(others) - ahead
        assert found == counted


# Shadowing.

PAIRS: Final = 3_000


def shadow(std_db: float = 4.0, seed: int = 1, number: int = 0) -> Shadowing:
    return Shadowing(
        std_db, 25.0, Draws(Seeds((seed,), PAIRS + 1), numbered(LOSS.number, number)), PAIRS + 1
    )


def values(shadowing: Shadowing, steps: int, step_m: float, both: bool = False) -> Floats:
    """Return the shadowing, (step, pair), of a vehicle that stands and 3,000 that move."""
    source, destination = np.arange(1, PAIRS + 1), np.zeros(PAIRS, dtype=np.int64)
    frames = SentFrames(source, destination, np.full(PAIRS, 100.0), np.zeros(PAIRS, dtype=np.int64))
    found = []
    for step in range(steps):
        position = np.full(PAIRS + 1, step * step_m)
        if not both:
            position[0] = 0.0
        found.append(shadowing.of(frames, Scene(step, step, position, None)))
    return np.array(found)


def test_shadowing_is_normal_at_any_time() -> None:
    found = values(shadow(), steps=40, step_m=5.0)
    for at in (0, 1, 39):
        assert stats.kstest(found[at], stats.norm(0.0, 4.0).cdf).pvalue > 0.01


@pytest.mark.parametrize(("both", "way"), [(False, 1.0), (True, 2.0)])
def test_shadowing_decorrelates_as_both_ends_travel(both: bool, way: float) -> None:
    found = values(shadow(), steps=30, step_m=5.0, both=both)
    for lag in (1, 3, 10):
        expected = np.exp(-lag * way * 5.0 / 25.0)
        correlation = float(np.array(np.corrcoef(found[0], found[lag]))[0, 1])
        spread = (1.0 - expected**2) / np.sqrt(PAIRS)
        assert correlation == pytest.approx(expected, abs=2.6 * spread)


def test_shadowing_of_standing_vehicles_is_constant() -> None:
    found = values(shadow(), steps=5, step_m=0.0)
    np.testing.assert_array_equal(found, np.broadcast_to(found[0], found.shape))


def test_shadowing_is_symmetric_and_independent_between_pairs() -> None:
    position = np.arange(60.0) * 20.0
    frames, shadowing = all_frames(position, None), shadow()
    for cycle in range(4):
        found = shadowing.of(frames, Scene(cycle, cycle, position + 3.0 * cycle, None))
        matrix = np.zeros((60, 60))
        matrix[frames.source, frames.destination] = found
        np.testing.assert_array_equal(matrix, matrix.T)
    upper = np.triu_indices(60, 1)
    assert len(np.unique(matrix[upper])) == len(upper[0])
    correlations = np.array(np.corrcoef(matrix + np.eye(60)))
    assert np.abs(correlations[upper]).mean() < 2.0 / np.sqrt(60)
    for other in (shadow(seed=2), shadow(number=1)):
        there = other.of(frames, Scene(0, 0, position, None))
        here = shadow().of(frames, Scene(0, 0, position, None))
        assert abs(float(np.array(np.corrcoef(there, here))[0, 1])) < 0.1


def test_shadowing_of_a_pair_does_not_depend_on_others() -> None:
    position = np.arange(30.0) * 20.0
    everyone, alone = shadow(), shadow()
    frames = all_frames(position, None)
    few = frames.only((frames.source < 3) & (frames.destination < 3))
    for cycle in range(5):
        scene = Scene(cycle, cycle, position + 3.0 * cycle, None)
        among = everyone.of(frames, scene)[(frames.source < 3) & (frames.destination < 3)]
        np.testing.assert_array_equal(alone.of(few, scene), among)


# The whole model, in a scenario.


def delivered(loss: Loss, *, gap_m: float = 37.5, cycles: int = 400, step_m: float = 3.0) -> Floats:
    """Return the share of delivered frames, by how many vehicles farther the receiver is."""
    size = 20
    channel = Channel(loss=loss)
    conditions = Conditions(Scenario(fleet=Fleet(size=size, gap_m=gap_m), channel=channel))
    start = np.arange(size - 1, -1, -1.0) * gap_m
    lost = []
    for cycle in range(cycles):
        position = start + step_m * cycle
        frames = all_frames(position, None, cycle)
        lost.append(conditions.of(frames, Scene(cycle, cycle * 100_000_000, position, None)).lost)
    apart = np.abs(frames.source - frames.destination)
    share = 1.0 - np.array(lost).mean(axis=0)
    return np.array([share[apart == k].mean() for k in range(1, size)])


def test_vehicles_between_limit_the_reach_in_a_line() -> None:
    free = delivered(Loss(path_loss=PathLoss(blockage_db=0.0)))
    blocked = delivered(Loss(path_loss=PathLoss()))
    assert free[:8].min() > 0.99  # 300 m
    assert blocked[0] > 0.999
    assert blocked[5:].max() < 0.01
    expected = []
    for k in range(1, 6):  # without fading: the share of the shadowing that leaves enough
        loss_db = float(path_loss_db(np.array([37.5 * k]), PLAIN)[0]) + 9.0 * (k - 1)
        expected.append(stats.norm(0.0, 3.95).cdf(23.0 - loss_db + 88.0))
    # 1,200 m are 96 decorrelation lengths (both vehicles move), with about 30 pairs of each kind.
    assert blocked[:5].tolist() == pytest.approx(expected, abs=0.04)


def test_each_frame_has_its_own_fading() -> None:
    """If the mean power is just enough, exp(-1) of the frames pass Rayleigh fading."""
    loss_db = float(path_loss_db(np.array([37.5]), PLAIN)[0])
    model = PathLoss(shadowing_db=0.0, fading_m=1.0, sensitivity_dbm=23.0 - loss_db)
    shares = delivered(Loss(path_loss=model), cycles=200)
    n = 200 * 38
    p = float(np.exp(-1.0))
    assert shares[0] == pytest.approx(p, abs=2.6 * np.sqrt(p * (1.0 - p) / n))
