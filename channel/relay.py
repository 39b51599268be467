"""Relay: receivers pass a frame on, hop by hop, to vehicles out of its sender's range.

A frame that a vehicle passes on has the outcome of the vehicle's own frame on that link in that
cycle: it is lost if that one is, and takes as long. So the latency of a relayed frame is the sum of
the latencies of its hops, and link states (bursts, outages, shadowing) hold for every frame on the
link.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


class Hop(NamedTuple):
    """Frames over single links in range, (r,), sorted by source.

    Source and destination are indices. latency_ns: -1 if the frame is lost.
    """

    source: Ints
    destination: Ints
    latency_ns: Ints


class Relayed(NamedTuple):
    """Frames over several links: total latency, ns (-1 if lost on every path), and hops."""

    source: Ints
    destination: Ints
    latency_ns: Ints
    hops: Ints


def relay(direct: Hop, size: int, most_hops: int) -> Relayed:
    """Return the frames that reach beyond their sender's range over at most `most_hops` links.

    Every pair that so many links connect has a row, even if the frame is lost on all paths. A pair
    is reached with as few hops as the links in range allow; the fastest path with that number of
    hops counts.
    """
    first = np.searchsorted(direct.source, np.arange(size + 1))
    reached = np.union1d(direct.source * size + direct.destination, np.arange(size) * (size + 1))
    front = direct
    found: list[Relayed] = []
    for hops in range(2, most_hops + 1):
        front = _next(front, direct, first, reached, size)
        if not len(front.source):
            break
        reached = np.union1d(reached, front.source * size + front.destination)
        found.append(Relayed(*front, np.full(len(front.source), hops)))
    empty = np.zeros(0, dtype=np.int64)
    columns = zip(Relayed(empty, empty, empty, empty), *found, strict=True)
    return Relayed._make(np.concatenate(column) for column in columns)


def _next(front: Hop, direct: Hop, first: Ints, reached: Ints, size: int) -> Hop:
    """Return the pairs reached with one more link than `front`, each by its fastest path.

    It joins `front` and `direct`: every frame of `front` continues over every link that begins
    where the frame ended. Links are sorted by source, so those of vehicle v are direct[first[v]] to
    direct[first[v + 1] - 1].
    """
    # A row per frame and link: `before` is an index in `front`, `link` in `direct`.
    count = first[front.destination + 1] - first[front.destination]
    before = np.repeat(np.arange(len(count)), count)
    within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    link = np.repeat(first[front.destination], count) + within
    # A pair of vehicles as one number. Pairs reached with fewer links are left out.
    code = front.source[before] * size + direct.destination[link]
    new = ~np.isin(code, reached)
    code, before, link = code[new], before[new], link[new]
    here, there = front.latency_ns[before], direct.latency_ns[link]
    never = np.iinfo(np.int64).max
    latency_ns = np.where((here < 0) | (there < 0), never, here + there)
    # The least latency over all rows of a pair; `never` if the frame is lost on every path.
    pairs, at = np.unique(code, return_inverse=True)
    fastest = np.full(len(pairs), never)
    np.minimum.at(fastest, at, latency_ns)
    source, destination = np.divmod(pairs, size)
    return Hop(source, destination, np.where(fastest == never, -1, fastest))
