"""Delivery, latency and consecutive losses of frames, as pure functions of columns.

They take the columns of /v2v/frames: a row per frame and receiver, in order of time. Frames out of
range of a receiver are not counted.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.columns import Table
from zenvoy.bus import messages_pb2 as pb

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_Z_95: Final = 1.959963984540054  # two-sided quantile of the normal distribution
_MIN_BIN_NS: Final = 1_000
_MAX_BINS: Final = 100_000


class Delivery(NamedTuple):
    """Numbers of frames by outcome; `delivered` includes the late ones."""

    sent: int
    delivered: int
    late: int
    lost: int
    corrupted: int = 0
    second_copies: int = 0
    collided: int = 0

    @property
    def missed(self) -> int:
        """Frames that the receiver could not use: lost, damaged or collided."""
        return self.lost + self.corrupted + self.collided


class Distances(NamedTuple):
    """Frames by distance: edges of bins (bins + 1,), m; numbers sent and delivered (bins,)."""

    edges_m: Floats
    sent: Ints
    delivered: Ints


class Latencies(NamedTuple):
    """Distribution of latencies: count in [k, k + 1) · width_ns, (bins,), and mean."""

    width_ns: int
    counts: Ints
    mean_ms: float

    def quantile_ms(self, share: float) -> float:
        """Return the latency that this share of frames does not exceed, ms, rounded to a bin."""
        reached = np.searchsorted(np.cumsum(self.counts), share * self.counts.sum())
        return float(reached * self.width_ns / 1e6)


def delivery(frames: Table) -> Delivery:
    """Count frames by outcome."""
    counts = np.bincount(frames["outcome"], minlength=max(pb.Outcome.values()) + 1)
    late, lost = int(counts[pb.OUTCOME_LATE]), int(counts[pb.OUTCOME_LOST])
    delivered, corrupted = (
        int(counts[pb.OUTCOME_DELIVERED]) + late,
        int(counts[pb.OUTCOME_CORRUPTED]),
    )
    collided = int(counts[pb.OUTCOME_COLLIDED])
    return Delivery(
        sent=delivered + lost + corrupted + collided,
        delivered=delivered,
        late=late,
        lost=lost,
        corrupted=corrupted,
        second_copies=int(counts[pb.OUTCOME_DUPLICATE]),
        collided=collided,
    )


def wilson(successes: NDArray[Any], trials: NDArray[Any]) -> tuple[Floats, Floats]:
    """Return the 95 % interval of a proportion (Wilson 1927); [0, 1] where there is no trial."""
    n = np.maximum(trials, 1).astype(np.float64)
    p, z2 = successes / n, _Z_95**2
    middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n)
    half = _Z_95 / (1.0 + z2 / n) * np.sqrt(p * (1.0 - p) / n + z2 / (4.0 * n**2))
    tried = np.asarray(trials) > 0
    low, high = np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
    # The ends are exactly 0 and 1; rounding would miss them slightly.
    low = np.where(tried & (np.asarray(successes) > 0), low, 0.0)
    return low, np.where(tried & (np.asarray(successes) < n), high, 1.0)


def by_distance(frames: Table, bins: int = 20) -> Distances:
    """Count frames by distance along the road, in at most `bins` bins of a round width."""
    on_air = on_the_air(frames)
    distance = frames["distance"]
    farthest = float(distance.max(where=on_air, initial=0.0))
    width = _round_width(farthest / bins)
    number = int(farthest // width) + 1
    at = (distance * np.float32(1.0 / width)).astype(np.uint16)
    np.minimum(at, number - 1, out=at)  # rounding may pass the last edge
    got = arrived(frames)
    return Distances(
        edges_m=width * np.arange(number + 1, dtype=np.float64),
        sent=np.bincount(at[on_air], minlength=number),
        delivered=np.bincount(at[got], minlength=number),
    )


def latencies(frames: Table) -> Latencies | None:
    """Return the distribution of latencies of delivered frames; None if there are none."""
    latency_ns = frames["latency_ns"]
    if frames["outcome"].size == 0 or (largest := int(latency_ns.max())) < 0:
        return None
    width_ns = max(_MIN_BIN_NS, -(-largest // _MAX_BINS))
    got = arrived(frames)
    known = latency_ns if got.all() else latency_ns[got]
    return Latencies(
        width_ns=width_ns,
        counts=np.bincount((known // width_ns).astype(np.int32)),
        mean_ms=float(known.mean()) / 1e6,
    )


def loss_bursts(frames: Table, vehicles: int) -> Ints:
    """Return the number of bursts of losses of each length, (longest + 1,).

    A burst is a maximal run of consecutive sequence numbers of one source that one destination
    could not use.
    """
    lost = np.flatnonzero(on_the_air(frames) & ~arrived(frames))
    if not lost.size:
        return np.zeros(1, dtype=np.int64)
    link = frames["source"][lost].astype(np.int64) * (vehicles + 1) + frames["destination"][lost]
    key = np.sort(link << 33 | frames["sequence"][lost])  # 33 bits keep links apart
    ends = np.flatnonzero(np.append(np.diff(key) != 1, True))
    return np.bincount(np.diff(ends, prepend=-1))


def geometric(loss_ratio: float, longest: int) -> Floats:
    """Return the share of bursts of each length under independent loss, (longest + 1,).

    It is (1 - p) p^(l - 1) for l = 1, 2, …, the geometric distribution.
    """
    length = np.arange(longest + 1)
    share = (1.0 - loss_ratio) * loss_ratio ** np.maximum(length - 1, 0)
    return np.where(length > 0, share, 0.0)


def on_the_air(frames: Table) -> NDArray[np.bool_]:
    """Return which rows were within range of their receiver, without second copies."""
    outcome = frames["outcome"]
    excluded = (outcome == pb.OUTCOME_OUT_OF_RANGE) | (outcome == pb.OUTCOME_DUPLICATE)
    return np.asarray(~excluded)


def arrived(frames: Table) -> NDArray[np.bool_]:
    """Return which rows reached their receiver, late or not; first copies only."""
    outcome = frames["outcome"]
    return np.asarray((outcome == pb.OUTCOME_DELIVERED) | (outcome == pb.OUTCOME_LATE))


def _round_width(at_least: float) -> float:
    """Return the smallest of 1, 2, 5, 10, 20, 50, … that is not below `at_least`."""
    power = 10.0 ** np.floor(np.log10(max(at_least, 1.0)))
    return float(next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= at_least))
