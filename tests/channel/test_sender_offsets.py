"""Senders hold an offset of latency for some messages, as long as their settings say."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from tests.channel.agreement import agrees
from zenvoy.channel.latency import Latencies
from zenvoy.channel.sender_offset import SenderOffsets
from zenvoy.keyed_random.draws import Seeds
from zenvoy.links.sent_frames import SentFrames
from zenvoy.scenarios import Latency, SenderOffset

Ints = NDArray[np.int64]

NS_PER_MS: Final = 1e6
TABLE_MS: Final = (20.0, 80.0)

SENDERS: Final = 400
MESSAGES: Final = 500


def frames(sequence: int, senders: Ints | None = None) -> SentFrames:
    source = np.arange(SENDERS) if senders is None else senders
    nobody = np.zeros(len(source), dtype=np.int64)
    return SentFrames(source, nobody, nobody.astype(np.float64), np.full(len(source), sequence))


def held(settings: SenderOffset, seed: int = 1, number: int = 0) -> Ints:
    """Return the offsets of all messages, (message, sender), ns."""
    offsets = SenderOffsets(settings, Seeds((seed,), SENDERS), number)
    return np.array([offsets.of(frames(sequence)) for sequence in range(MESSAGES)])


def spans(offsets: Ints) -> Ints:
    """Return for how many messages each offset is held, without the last of each sender."""
    lengths = []
    for column in offsets.T:
        changes = np.flatnonzero(np.diff(column)) + 1
        lengths.append(np.diff(np.concatenate([[0], changes])))
    return np.concatenate(lengths)


def test_offsets_are_held_for_a_number_of_messages() -> None:
    offsets = held(SenderOffset(max_ms=100.0))
    lengths, counts = np.unique(spans(offsets), return_counts=True)
    assert lengths.tolist() == list(range(5, 16))
    # Every length is equally likely among the first 30 spans of a sender, which are all complete.
    first = np.concatenate([spans(column[:, None])[:30] for column in offsets.T])
    assert stats.chisquare(np.unique(first, return_counts=True)[1]).pvalue > 0.01
    assert counts.min() > 0
    assert agrees(offsets[0] / NS_PER_MS, stats.uniform(0.0, 100.0).cdf)
    assert agrees(offsets[-1] / NS_PER_MS, stats.uniform(0.0, 100.0).cdf)


def test_each_sender_and_rule_has_its_own_offsets() -> None:
    offsets = held(SenderOffset(max_ms=100.0))
    anew = offsets[::15, :20]  # no offset is held for more than 15
    correlations = np.array(np.corrcoef(anew.T))
    apart = correlations[~np.eye(20, dtype=bool)]
    assert np.abs(apart).max() < 4.0 / np.sqrt(len(anew))
    for other in (
        held(SenderOffset(max_ms=100.0), seed=2),
        held(SenderOffset(max_ms=100.0), number=1),
    ):
        assert (other != offsets).mean() > 0.99


def test_autocorrelation_decays_as_spans_end() -> None:
    """After d messages the same offset holds with probability E[max(0, L - d)] / E[L]."""
    offsets = held(SenderOffset(max_ms=100.0))[100:] / 1e8 - 0.5
    lengths = np.arange(5, 16)
    for lag in (1, 5, 10, 15):
        expected = np.maximum(lengths - lag, 0).mean() / lengths.mean()
        found = (offsets[lag:] * offsets[:-lag]).mean() / (offsets**2).mean()
        assert found == pytest.approx(expected, abs=0.03)


def test_offsets_may_outlast_a_pick() -> None:
    settings = SenderOffset(max_ms=100.0, from_messages=3, to_messages=3, keep=0.8)
    offsets = held(settings)[::3]  # a pick at each
    keeps = (np.diff(offsets, axis=0) == 0).mean()
    picks = offsets[1:].size
    assert keeps == pytest.approx(0.8, abs=2.6 * np.sqrt(0.16 / picks))


@given(st.lists(st.integers(1, 40), min_size=1, max_size=8))
def test_offsets_do_not_depend_on_the_order_of_queries(steps: list[int]) -> None:
    settings = SenderOffset(max_ms=100.0)
    often, seldom = (SenderOffsets(settings, Seeds((1,), SENDERS)) for _ in range(2))
    sequence = 0
    for step in steps:
        for number in range(sequence, sequence + step):
            all_of_them = often.of(frames(number))
        sequence += step
        np.testing.assert_array_equal(
            seldom.of(frames(sequence - 1, np.array([3, 7]))), all_of_them[[3, 7]]
        )


def test_a_frame_has_the_offset_beside_its_own_latency() -> None:
    offset = SenderOffset(max_ms=100.0)
    plain, shifted = (
        Latencies(Latency(sender_offset=offsets), TABLE_MS, Seeds((1,), SENDERS))
        for offsets in (SenderOffset(), offset)
    )
    share = np.linspace(0.0, 0.999, SENDERS)
    shift = SenderOffsets(offset, Seeds((1,), SENDERS)).of(frames(0))
    np.testing.assert_array_equal(shifted.of(frames(0), share), plain.of(frames(0), share) + shift)
