"""Latencies have scipy's distributions, and wrong settings are refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from tests.channel.agreement import agrees
from tests.refused import refused
from zenvoy.channel.latency import Latencies
from zenvoy.keyed_random.draws import Purpose, Seeds, uniforms
from zenvoy.links.distribution import Delays
from zenvoy.links.table import distributions
from zenvoy.scenarios import Latency, ScenarioError, load

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
