"""Rules, loss by distance, damage, duplicates and reordering do what the scenario says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.channel.ring_of_thirty import (
    DESTINATION,
    DISTANCE,
    MS_NS,
    POSITION,
    S_NS,
    SOURCE,
    scenario,
    within,
)
from tests.refused import refused
from zenvoy.channel.conditions import Conditions, Impairments
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import Channel, GilbertElliott, Latency, Loss, Rule, technologies


def frames(sequence: int) -> SentFrames:
    return SentFrames(SOURCE, DESTINATION, DISTANCE, np.full(len(SOURCE), sequence))


def ways(channel: Channel, count: int = 60) -> Impairments:
    """Return the impairments, (count, links), of frames that each link sends every 0.1 s."""
    conditions = Conditions(scenario(channel))
    found = [
        conditions.of(frames(n), Scene(n, n * S_NS // 10, POSITION, 600.0)) for n in range(count)
    ]
    return Impairments(*map(np.array, zip(*found, strict=True)))


def test_loss_by_distance_is_linear_between_its_points() -> None:
    table = ((50.0, 0.0), (150.0, 0.4), (250.0, 0.6))
    lost = ways(Channel(loss=Loss(by_distance=table)), count=400).lost
    for metres, p in ((20.0, 0.0), (60.0, 0.04), (100.0, 0.2), (200.0, 0.5), (300.0, 0.6)):
        there = lost[:, np.isclose(DISTANCE, metres)]
        assert within(there.mean(), p, there.size), metres


def test_loss_by_distance_adds_to_independent_loss() -> None:
    loss = Loss(p=0.5, by_distance=((0.0, 0.2),))
    lost = ways(Channel(loss=loss), count=200).lost
    assert within(lost.mean(), 1.0 - 0.5 * 0.8, lost.size)


def test_damaged_frames_are_not_lost_frames() -> None:
    way = ways(Channel(loss=Loss(p=0.3, corrupt=0.1)), count=200)
    assert within(way.damaged.mean(), 0.1, way.damaged.size)
    assert within(way.damaged[way.lost].mean(), 0.1, int(way.lost.sum()))


def test_the_last_rule_that_applies_wins() -> None:
    rules = (
        Rule(from_s=1.0, until_s=2.0, loss=Loss(p=1.0)),
        Rule(source="1", loss=Loss(), latency=Latency(distribution="fixed", mean_ms=50.0)),
        Rule(destination="2", latency=Latency(distribution="fixed", mean_ms=70.0)),
    )
    way = ways(Channel(loss=Loss(p=0.0), rules=rules))
    during = np.zeros(60, dtype=bool)
    during[10:20] = True
    first = SOURCE == 0
    assert way.lost[during][:, ~first].all()
    assert not way.lost[:, first].any()  # its rule has its own loss, which is none
    assert not way.lost[~during].any()
    second = DESTINATION == 1
    assert (way.latency_ns[:, second] == 70 * MS_NS).all()
    assert (way.latency_ns[:, first & ~second] == 50 * MS_NS).all()
    assert (way.latency_ns[:, ~first & ~second] == 10 * MS_NS).all()


def test_a_rule_on_a_stretch() -> None:
    rule = Rule(from_m=580.0, to_m=10.0, loss=Loss(p=1.0))  # over the seam: vehicles 1 and 30
    lost = ways(Channel(rules=(rule,)), count=1).lost[0]
    ends = np.isin(SOURCE, (0, 29)) | np.isin(DESTINATION, (0, 29))
    np.testing.assert_array_equal(lost, ends)


def test_a_rule_equal_to_the_channel_changes_nothing() -> None:
    bursts = Loss(p=0.2, corrupt=0.1)
    latency = Latency(distribution="gamma", mean_ms=20.0, std_ms=5.0)
    plain = Channel(loss=bursts, latency=latency)
    ruled = Channel(loss=Loss(p=0.9), rules=(Rule(loss=bursts, latency=latency),))
    for one, other in zip(ways(plain), ways(ruled), strict=True):
        np.testing.assert_array_equal(one, other)


def test_each_rule_has_its_own_bursts() -> None:
    bursts = Loss(gilbert_elliott=GilbertElliott(p=0.1, r=0.3))
    plain = ways(Channel(loss=bursts), count=300).lost
    ruled = ways(Channel(rules=(Rule(loss=bursts),)), count=300).lost
    assert 0.2 < plain.mean() < 0.3
    assert 0.2 < ruled.mean() < 0.3
    assert abs(np.corrcoef(plain.ravel(), ruled.ravel())[0, 1]) < 0.01


def test_a_rule_does_not_change_the_draws_of_other_links() -> None:
    loss = Loss(p=0.3, gilbert_elliott=GilbertElliott(p=0.05, r=0.5))
    plain = ways(Channel(technology=technologies()["lte-a-pro"], loss=loss))
    rule = Rule(source="3", loss=Loss(p=0.9), latency=Latency(distribution="fixed", mean_ms=1.0))
    ruled = ways(Channel(technology=technologies()["lte-a-pro"], loss=loss, rules=(rule,)))
    others = SOURCE != 2
    for one, other in zip(plain, ruled, strict=True):
        np.testing.assert_array_equal(one[:, others], other[:, others])
    assert (plain.lost[:, ~others] != ruled.lost[:, ~others]).any()


# Through the channel's agent: the frames that it reports, and those that vehicles hear.


@pytest.mark.parametrize(
    ("channel", "line"),
    [
        ("{loss: {by_distance: [[100, 0], [100, 1]]}}",
         "channel.loss.by_distance.1.0: 100 is not greater than the distance before (100)"),
        ("{loss: {by_distance: [[100, 2]]}}", "channel.loss.by_distance.0.1: 2 is not in [0, 1]"),
        ("{duplicate: -1}", "channel.duplicate: -1 is not in [0, 1]"),
        ("{rules: [{loss: {p: 2}}]}", "channel.rules.0.loss.p: 2 is not in [0, 1]"),
        ("{rules: [{}, {latency: {distribution: fixed}}]}",
         "channel.rules.1.latency.mean_ms: missing; channel.rules.1.latency.distribution is fixed"),
        ("{rules: [{source: 41}]}", "channel.rules.0.source: "),
        ("{rules: [{until_s: 3, from_s: 3}]}",
         "channel.rules.0.until_s: 3 is not later than channel.rules.0.from_s (3)"),
        ("{rules: [{los: 3}]}", "channel.rules.0.los: unknown key; did you mean 'loss'?"),
    ],
)  # fmt: skip
def test_wrong_settings_are_refused(tmp_path: Path, channel: str, line: str) -> None:
    (found,) = refused(tmp_path, f"channel: {channel}\n")
    assert found.startswith(line)
