"""The generator gives its published answers, and draws with the right distributions."""

from __future__ import annotations

import math
from collections.abc import Callable
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Purpose, normals, philox, uniforms

Floats = NDArray[np.float64]

MANY = np.arange(50_000)


@pytest.mark.parametrize(
    ("counter", "key", "answer"),
    [
        ("00000000 00000000 00000000 00000000", "00000000 00000000",
         "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
        ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff",
         "408f276d 41c83b0e a20bc7c6 6d5451fd"),
        ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0",
         "d16cfe09 94fdcceb 5001e420 24126ea1"),
    ],
)  # fmt: skip
def test_known_answers_of_random123(counter: str, key: str, answer: str) -> None:
    k0, k1 = (int(word, 16) for word in key.split())
    c0, c1, c2, c3 = (np.array(int(word, 16), dtype=np.uint64) for word in counter.split())
    words = philox((np.uint64(k0), np.uint64(k1)), (c0, c1, c2, c3))
    assert [f"{int(word):08x}" for word in words] == answer.split()


def test_draws_are_made_of_53_bits_each() -> None:
    """The bits are pinned, since the same seed must lose the same frames in every version."""
    seed, who, whom, number = 0x123456789ABCDEF0, 7, 8, 1_000_000
    counter = (Purpose.LOSS_AND_LATENCY, who, whom, number)
    c0, c1, c2, c3 = (np.array(part, dtype=np.uint64) for part in counter)
    key = (np.uint64(0x9ABCDEF0), np.uint64(0x12345678))
    w0, w1, w2, w3 = (int(w) for w in philox(key, (c0, c1, c2, c3)))
    first, second = uniforms(seed, Purpose.LOSS_AND_LATENCY, who, whom, number)
    assert float(first) == ((w0 >> 5) * 2**26 + (w1 >> 6)) / 2**53
    assert float(second) == ((w2 >> 5) * 2**26 + (w3 >> 6)) / 2**53


# Kolmogorov's limit, Pr(√n D > x) ≈ 2 exp(-2 x²), at which right draws fail once in a hundred runs
# of all comparisons below: two seeds, two draws and a normal one for every purpose.
KOLMOGOROV = math.sqrt(-0.5 * math.log(0.5 * 0.01 / (2 * 3 * len(Purpose))))


def kolmogorov_smirnov(draws: Floats, distribution: Callable[[float], float]) -> float:
    """Return √n times the largest distance between the draws and the distribution."""
    n = len(draws)
    cumulated = np.array([distribution(value) for value in np.sort(draws).tolist()])
    above, below = np.arange(1, n + 1) / n - cumulated, cumulated - np.arange(n) / n
    return float(np.sqrt(n) * max(above.max(), below.max()))


@pytest.mark.parametrize("seed", [1, 2**40 + 7])
@pytest.mark.parametrize("purpose", list(Purpose))
def test_draws_have_their_distributions(seed: int, purpose: Purpose) -> None:
    first, second = uniforms(seed, purpose, 3, 4, MANY)
    for draws in (first, second):
        assert draws.min() >= 0.0
        assert draws.max() < 1.0
        assert kolmogorov_smirnov(draws, lambda value: value) < KOLMOGOROV
    normal = normals(seed, purpose, 3, 4, MANY)
    assert kolmogorov_smirnov(normal, NormalDist().cdf) < KOLMOGOROV


def test_wrong_draws_fail() -> None:
    draws, _ = uniforms(1, Purpose.GAP_READING, 3, 4, MANY)
    assert kolmogorov_smirnov(draws * 0.98, lambda value: value) > KOLMOGOROV
    normal = normals(1, Purpose.GAP_READING, 3, 4, MANY)
    assert kolmogorov_smirnov(normal * 1.05, NormalDist().cdf) > KOLMOGOROV


def correlation(a: Floats, b: Floats) -> float:
    """Return the correlation, in standard deviations of that of independent draws."""
    return float(np.corrcoef(a, b)[0, 1] * np.sqrt(len(a)))


def test_draws_of_different_keys_are_independent() -> None:
    reference = uniforms(1, Purpose.GAP_READING, 3, 4, MANY)
    others = {
        "seed": uniforms(2, Purpose.GAP_READING, 3, 4, MANY),
        "high half of the seed": uniforms(1 + 2**32, Purpose.GAP_READING, 3, 4, MANY),
        "purpose": uniforms(1, Purpose.SPEED_READING, 3, 4, MANY),
        "who": uniforms(1, Purpose.GAP_READING, 4, 4, MANY),
        "whom": uniforms(1, Purpose.GAP_READING, 3, 5, MANY),
        "who and whom": uniforms(1, Purpose.GAP_READING, 4, 3, MANY),
        "number": uniforms(1, Purpose.GAP_READING, 3, 4, MANY + 1),
    }
    for name, other in others.items():
        for a in reference:
            for b in other:
                assert abs(correlation(a, b)) < 3.5, name
                assert not np.isin(a[:100], b).any() or name == "number", name
    assert abs(correlation(*reference)) < 3.5
    assert abs(correlation(reference[0][1:], reference[0][:-1])) < 3.5


keys = st.lists(
    st.tuples(st.integers(0, 10_000), st.integers(0, 10_000), st.integers(0, 2**32 - 1)),
    min_size=1,
    max_size=8,
)


@settings(deadline=None)
@given(st.integers(0, 2**63 - 1), st.sampled_from(list(Purpose)), keys)
def test_draws_together_equal_draws_one_by_one(
    seed: int, purpose: Purpose, of: list[tuple[int, int, int]]
) -> None:
    who, whom, number = (np.array(column) for column in zip(*of, strict=True))
    first, second = uniforms(seed, purpose, who, whom, number)
    normal = normals(seed, purpose, who, whom, number)
    for row, key in enumerate(of):
        assert uniforms(seed, purpose, *key) == (first[row], second[row])
        assert normals(seed, purpose, *key) == normal[row]


def test_draws_broadcast_over_rows_and_columns() -> None:
    vehicles, cycles = np.arange(1, 6), np.arange(7)[:, None]
    block, _ = uniforms(9, Purpose.GAP_READING, vehicles, 0, cycles)
    assert block.shape == (7, 5)
    for cycle in range(7):
        row, _ = uniforms(9, Purpose.GAP_READING, vehicles, 0, cycle)
        np.testing.assert_array_equal(block[cycle], row)
