"""Random numbers keyed by who and what, never taken in order of arrival.

Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3") maps a key and
a counter to 128 random bits, without state. numpy's own Philox needs a generator object per key.
Here each frame and each reading has its own key, so there are thousands per cycle.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from zenvoy.keyed_random.quantile import normal_quantile

Words = NDArray[np.uint64]
Floats = NDArray[np.float64]

_MASK: Final = np.uint64(0xFFFFFFFF)
_SHIFT: Final = np.uint64(32)
_MULTIPLIERS: Final = (np.uint64(0xD2511F53), np.uint64(0xCD9E8D57))
_WEYL: Final = (0x9E3779B9, 0xBB67AE85)
_ROUNDS: Final = 10


class Purpose(IntEnum):
    """What a draw is for; draws for different purposes are independent.

    Records of loss models have purposes of their own: `zenvoy.links.table` sees to it that these
    are others.
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


def numbered(purpose: int, number: int) -> int:
    """Return one of many purposes of a kind, such as for a channel's rules; 0 is the kind."""
    return int(purpose) + 256 * number


def philox(key: tuple[int, int], counter: tuple[Words, Words, Words, Words]) -> list[Words]:
    """Return four words of 32 random bits, each of the counter's broadcast shape."""
    c0, c1, c2, c3 = counter
    for number in range(_ROUNDS):
        k0 = np.uint64((key[0] + number * _WEYL[0]) & 0xFFFFFFFF)
        k1 = np.uint64((key[1] + number * _WEYL[1]) & 0xFFFFFFFF)
        p0 = c0 * _MULTIPLIERS[0]
        p1 = c2 * _MULTIPLIERS[1]
        c0, c1 = (p1 >> _SHIFT) ^ c1 ^ k0, p1 & _MASK
        c2, c3 = (p0 >> _SHIFT) ^ c3 ^ k1, p0 & _MASK
    return list(np.broadcast_arrays(c0, c1, c2, c3))


def uniforms(
    seed: int, purpose: int, who: ArrayLike, whom: ArrayLike, number: ArrayLike
) -> tuple[Floats, Floats]:
    """Return two independent draws in [0, 1), of the broadcast shape of who, whom and number."""
    key = (seed & 0xFFFFFFFF, seed >> 32)
    c0, c1, c2, c3 = (np.asarray(part, np.uint64) for part in (int(purpose), who, whom, number))
    w0, w1, w2, w3 = philox(key, (c0, c1, c2, c3))
    return _fraction(w0, w1), _fraction(w2, w3)


def normals(seed: int, purpose: int, who: ArrayLike, whom: ArrayLike, number: ArrayLike) -> Floats:
    """Return standard normal draws: the quantiles of the first uniform ones."""
    return normal_quantile(uniforms(seed, purpose, who, whom, number)[0])


@dataclass(frozen=True, slots=True)
class Draws:
    """Draws from one seed for one purpose."""

    seed: int
    purpose: int

    def uniforms(self, who: ArrayLike, whom: ArrayLike, number: ArrayLike) -> tuple[Floats, Floats]:
        """Return two independent draws in [0, 1), of the broadcast shape of the arguments."""
        return uniforms(self.seed, self.purpose, who, whom, number)

    def normals(self, who: ArrayLike, whom: ArrayLike, number: ArrayLike) -> Floats:
        """Return standard normal draws, of the broadcast shape of the arguments."""
        return normals(self.seed, self.purpose, who, whom, number)


def _fraction(high: Words, low: Words) -> Floats:
    """Return 53 random bits as a double in [0, 1)."""
    bits = (high >> np.uint64(5)) * np.uint64(1 << 26) + (low >> np.uint64(6))
    return bits.astype(np.float64) / float(1 << 53)
