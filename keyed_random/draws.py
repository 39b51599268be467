"""Random numbers keyed by seed, purpose, vehicles and number, never by order of arrival.

Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3") maps a key and a
counter to 128 random bits, without state. numpy's own Philox needs a generator object per key. Here
each frame and each reading has its own key, so there are thousands of keys per cycle.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from zenvoy.keyed_random.quantile import normal_quantile

Words = NDArray[np.uint64]
Key = Words | np.uint64
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MASK: Final = np.uint64(0xFFFFFFFF)
_SHIFT: Final = np.uint64(32)
_MULTIPLIERS: Final = (np.uint64(0xD2511F53), np.uint64(0xCD9E8D57))
_WEYL: Final = (np.uint64(0x9E3779B9), np.uint64(0xBB67AE85))
_ROUNDS: Final = 10


class Purpose(IntEnum):
    """The purpose of a draw; draws for different purposes are independent.

    Records of loss models have their own purposes; `zenvoy.links.table` makes sure that these are
    different.
    """

    LOSS_AND_LATENCY = 1
    GAP_READING = 2
    SPEED_READING = 3
    TARGET_SPEED_READING = 4
    POSITION_READING = 5
    SENDER_OFFSET = 22
    SENDER_KEEPS = 23
    CORRUPTION = 24
    DUPLICATION = 25
    PHASE = 27
    BACKOFF = 28
    LAW = 29
    STUDY_AXIS = 30
    SEARCH = 31
    FAULT = 32
    LOSS_BY_HAND = 33


def numbered(purpose: int, number: int) -> int:
    """Return the purpose with this number among those of a kind, such as one for each rule.

    Number 0 gives the purpose itself.
    """
    return int(purpose) + 256 * number


def philox(key: tuple[Key, Key], counter: tuple[Words, Words, Words, Words]) -> list[Words]:
    """Return four words of 32 random bits, each of the broadcast shape of key and counter."""
    k0, k1 = key
    c0, c1, c2, c3 = counter
    for number in range(_ROUNDS):
        if number:
            k0, k1 = (k0 + _WEYL[0]) & _MASK, (k1 + _WEYL[1]) & _MASK
        p0 = c0 * _MULTIPLIERS[0]
        p1 = c2 * _MULTIPLIERS[1]
        c0, c1 = (p1 >> _SHIFT) ^ c1 ^ k0, p1 & _MASK
        c2, c3 = (p0 >> _SHIFT) ^ c3 ^ k1, p0 & _MASK
    return list(np.broadcast_arrays(c0, c1, c2, c3))


def uniforms(
    seed: ArrayLike, purpose: int, who: ArrayLike, whom: ArrayLike, number: ArrayLike
) -> tuple[Floats, Floats]:
    """Return two independent draws in [0, 1), of the broadcast shape of seed, who, whom, number."""
    seeds = np.asarray(seed, np.uint64)
    key = (seeds & _MASK, seeds >> _SHIFT)
    c0, c1, c2, c3 = (np.asarray(part, np.uint64) for part in (int(purpose), who, whom, number))
    w0, w1, w2, w3 = philox(key, (c0, c1, c2, c3))
    return _fraction(w0, w1), _fraction(w2, w3)


def normals(
    seed: ArrayLike, purpose: int, who: ArrayLike, whom: ArrayLike, number: ArrayLike
) -> Floats:
    """Return standard normal draws: the quantiles of the first uniform ones."""
    return normal_quantile(uniforms(seed, purpose, who, whom, number)[0])


@dataclass(frozen=True, slots=True)
class Seeds:
    """The seeds of runs side by side, each with a fleet of `size`.

    Vehicle i of run s has the index s · size + i - 1; i counts from 1 and s from 0.
    """

    each: tuple[int, ...]
    size: int

    def of(self, index: Ints) -> ArrayLike:
        """Return the seed of the run that a vehicle belongs to."""
        if len(self.each) == 1:
            return self.each[0]
        return np.array(self.each, np.uint64)[index // self.size]

    def numbers(self, index: Ints) -> Ints:
        """Return the numbers of vehicles in their run, from 1."""
        return index + 1 if len(self.each) == 1 else index % self.size + 1

    @property
    def vehicles(self) -> int:
        """The number of vehicles in all runs."""
        return len(self.each) * self.size


@dataclass(frozen=True, slots=True)
class Draws:
    """Draws for one purpose. The draws of a vehicle do not depend on the other runs."""

    seeds: Seeds
    purpose: int

    def of_links(self, source: Ints, destination: Ints, number: ArrayLike) -> tuple[Floats, Floats]:
        """Return two independent draws in [0, 1) for each link and number; indices from 0."""
        seeds = self.seeds
        who, whom = seeds.numbers(source), seeds.numbers(destination)
        return uniforms(seeds.of(source), self.purpose, who, whom, number)

    def of_vehicles(
        self, index: Ints, number: ArrayLike, purpose_number: int = 0
    ) -> tuple[Floats, Floats]:
        """Return two independent draws in [0, 1) for each vehicle and number; indices from 0."""
        seeds = self.seeds
        who = seeds.numbers(index)
        return uniforms(seeds.of(index), self.purpose, who, purpose_number, number)

    def normals_of_links(self, source: Ints, destination: Ints, number: ArrayLike) -> Floats:
        """Return standard normal draws for each link and number; indices from 0."""
        return normal_quantile(self.of_links(source, destination, number)[0])


def _fraction(high: Words, low: Words) -> Floats:
    """Return 53 random bits as a double in [0, 1)."""
    bits = (high >> np.uint64(5)) * np.uint64(1 << 26) + (low >> np.uint64(6))
    return bits.astype(np.float64) / float(1 << 53)
