"""Latencies have scipy's distributions, senders hold offsets, and wrong settings are refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from tests.refused import refused
from zenvoy.channel.latency import Latencies
from zenvoy.channel.sender_offset import SenderOffsets
from zenvoy.keyed_random.draws import Purpose, Seeds, uniforms
from zenvoy.links.distribution import Delays
from zenvoy.links.sent_frames import SentFrames
from zenvoy.links.table import distributions
from zenvoy.scenarios import Latency, ScenarioError, SenderOffset, load

Ints = NDArray[np.int64]

NS_PER_MS: Final = 1e6
DRAWS: Final = 200_000
TABLE_MS: Final = (20.0, 80.0)

# Each with scipy's distribution in ms, truncated at the bounds.
SHAPES: Final[list[tuple[Latency, Any]]] = [
    (Latency(), stats.uniform(20.0, 60.0)),
    (Latency(distribution="uniform", min_ms=5.0, max_ms=30.0), stats.uniform(5.0, 25.0)),
    (
        Latency(distribution="normal", mean_ms=20.0, std_ms=5.0),
        stats.truncnorm(-4.0, np.inf, loc=20.0, scale=5.0),
    ),
    (
        Latency(distribution="normal", mean_ms=20.0, std_ms=10.0, min_ms=15.0, max_ms=45.0),
        stats.truncnorm(-0.5, 2.5, loc=20.0, scale=10.0),
    ),
    (
        Latency(distribution="gamma", mean_ms=30.0, std_ms=10.0, min_ms=10.0),
        stats.gamma(4.0, loc=10.0, scale=5.0),
    ),
    (Latency(distribution="gamma", mean_ms=3.0, std_ms=3.0), stats.expon(scale=3.0)),
    (Latency(distribution="pareto", min_ms=10.0, mean_ms=15.0), stats.pareto(3.0, scale=10.0)),
    (
        Latency(distribution="pareto", min_ms=10.0, mean_ms=15.0, max_ms=40.0),
        stats.truncpareto(3.0, 4.0, scale=10.0),
    ),
]
CUT: Final = Latency(distribution="gamma", mean_ms=30.0, std_ms=10.0, min_ms=10.0, max_ms=35.0)


def delays(latency: Latency) -> Delays:
    return distributions()[latency.distribution].quantile(latency, TABLE_MS)


def latencies_ms(latency: Latency, seed: int = 1) -> NDArray[np.float64]:
    _, share = uniforms(seed, Purpose.LOSS_AND_LATENCY, 1, 2, np.arange(DRAWS))
    return delays(latency)(share) / NS_PER_MS


def agrees(draws_ms: NDArray[np.float64], cdf: Callable[[Any], Any]) -> bool:
    """Return whether draws pass a Kolmogorov-Smirnov test at 1 %, which does not see whole ns."""
    return bool(stats.kstest(draws_ms, cdf).pvalue > 0.01)


@pytest.mark.parametrize(("latency", "shape"), SHAPES, ids=[s.distribution for s, _ in SHAPES])
def test_distributions_are_scipys(latency: Latency, shape: Any) -> None:
    draws_ms = latencies_ms(latency)
    assert agrees(draws_ms, shape.cdf)
    # The test must reject the same distribution, shifted by two hundredths of its spread.
    low, high = shape.ppf([0.25, 0.75])
    assert not agrees(draws_ms + 0.02 * (high - low), shape.cdf)
    share = 0.9
    spread = np.sqrt(share * (1.0 - share) / DRAWS)
    assert (draws_ms <= shape.ppf(share)).mean() == pytest.approx(share, abs=2.6 * spread)


def test_gamma_is_truncated() -> None:
    shape = stats.gamma(4.0, loc=10.0, scale=5.0)
    draws_ms = latencies_ms(CUT)
    assert draws_ms.max() <= 35.0
    assert agrees(draws_ms, lambda ms: np.minimum(shape.cdf(ms) / shape.cdf(35.0), 1.0))


@pytest.mark.parametrize("shape", [0.3, 1.0, 4.0, 100.0])
def test_gamma_is_scipys_quantile_at_every_draw(shape: float) -> None:
    """They agree to 1e-4 of the deviation between the tails, and to a nanosecond in them."""
    scale_ms = 1_000.0
    latency = Latency(
        distribution="gamma", mean_ms=shape * scale_ms, std_ms=math.sqrt(shape) * scale_ms
    )
    draws = np.linspace(0.0, 1.0, 100_001)[:-1]
    found_ms = delays(latency)(draws) / NS_PER_MS
    off_ms = np.abs(found_ms - stats.gamma(shape, scale=scale_ms).ppf(draws))
    assert off_ms.max() < 1e-4 * math.sqrt(shape) * scale_ms
    assert off_ms[(draws < 0.0099) | (draws > 0.9901)].max() < 1e-5


def test_a_technology_may_have_no_delay() -> None:
    latencies = Latencies(Latency(), (0.0, 0.0), Seeds((1,), 2))
    assert latencies.least_ns == 0
    assert not latencies.draws


def test_a_fixed_latency_is_constant() -> None:
    assert set(latencies_ms(Latency(distribution="fixed", mean_ms=12.5)).tolist()) == {12.5}


def test_samples_are_drawn_in_proportion_to_their_number() -> None:
    latency = Latency(distribution="samples", samples_ms=(30.0, 10.0, 10.0, 20.5))
    values, counts = np.unique(latencies_ms(latency), return_counts=True)
    assert values.tolist() == [10.0, 20.5, 30.0]
    assert stats.chisquare(counts, np.array([0.5, 0.25, 0.25]) * DRAWS).pvalue > 0.01


@given(
    st.sampled_from([*(latency for latency, _ in SHAPES), CUT]),
    st.lists(st.integers(0, 2**53 - 1), min_size=2, max_size=10),
)
def test_a_later_draw_is_a_later_frame(latency: Latency, parts: list[int]) -> None:
    draws = np.array(sorted(parts)) / 2**53
    found = delays(latency)(draws)
    assert (np.diff(found) >= 0).all()
    assert found.min() >= round((latency.min_ms or 0.0) * NS_PER_MS)
    if latency.max_ms is not None:
        assert found.max() <= round(latency.max_ms * NS_PER_MS)
    least_ns = Latencies(latency, TABLE_MS, Seeds((1,), 2)).least_ns
    assert delays(latency)(np.zeros(1)) == least_ns <= found.min()


# Offsets that senders hold.

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


# In a scenario.


@pytest.mark.parametrize(
    ("latency", "line"),
    [
        (
            "{distribution: gaussian}",
            "channel.latency.distribution: 'gaussian' is not one of technology, fixed, uniform, "
            "normal, gamma, pareto, samples",
        ),
        (
            "{distribution: fixed}",
            "channel.latency.mean_ms: missing; channel.latency.distribution is fixed, which needs "
            "mean_ms",
        ),
        (
            "{distribution: fixed, mean_ms: 5, std_ms: 1}",
            "channel.latency.std_ms: is given, but channel.latency.distribution is fixed; "
            "allowed: null",
        ),
        (
            "{mean_ms: 5}",
            "channel.latency.mean_ms: is given, but channel.latency.distribution is technology; "
            "allowed: null",
        ),
        (
            "{distribution: uniform, min_ms: 20, max_ms: 10}",
            "channel.latency.max_ms: 10 is less than channel.latency.min_ms (20)",
        ),
        (
            "{distribution: pareto, min_ms: 20, mean_ms: 20}",
            "channel.latency.mean_ms: 20 is not greater than channel.latency.min_ms (20)",
        ),
        (
            "{distribution: pareto, min_ms: 0, mean_ms: 20}",
            "channel.latency.min_ms: 0 is not greater than 0, which pareto needs",
        ),
        (
            "{sender_offset: {from_messages: 5, to_messages: 4}}",
            "channel.latency.sender_offset.to_messages: 4 is less than "
            "channel.latency.sender_offset.from_messages (5)",
        ),
        ("{distribution: samples, file: none.csv}", "channel.latency.file: "),
        (
            "{distribution: samples, file: a.csv, samples_ms: [1]}",
            "channel.latency.file: given together with samples_ms; allowed: one of the two",
        ),
    ],
)
def test_wrong_settings_are_refused(tmp_path: Path, latency: str, line: str) -> None:
    (found,) = refused(tmp_path, f"channel: {{latency: {latency}}}\n")
    assert found.startswith(line)
    assert "s.yaml" in found


def test_samples_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text("channel: {latency: {distribution: samples, file: measured.csv}}\n")
    (tmp_path / "measured.csv").write_text("latency_ms\n10.5\n30\n")
    assert load(path).scenario.channel.latency.samples_ms == (10.5, 30.0)
    path.write_text("channel: {rules: [{latency: {distribution: samples, file: measured.csv}}]}\n")
    latency = load(path).scenario.channel.rules[0].latency
    assert latency is not None
    assert latency.samples_ms == (10.5, 30.0)
    (tmp_path / "measured.csv").write_text("latency_ms\n10.5\nfast\n")
    with pytest.raises(ScenarioError, match=r"latency_ms: 'fast' is not a number .*csv, line 3"):
        load(path)
