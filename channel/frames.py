"""The outcomes of the frames of a cycle: when they arrive, and how the log classes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.conditions import Impairments
from zenvoy.channel.in_order import InOrder
from zenvoy.channel.pairs import Pairs
from zenvoy.scenarios import Technology

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class OnAir:
    """A technology and the frames that it carries.

    on_air_ns: the time on the air of a frame under carrier sense; None without carrier sense.
    """

    technology: Technology
    frame_bytes: int
    on_air_ns: int | None = None

    @property
    def frame_time_ns(self) -> int:
        """Time on the air: bits of the frame over bit rate, unless `on_air_ns` gives it."""
        if self.on_air_ns is not None:
            return self.on_air_ns
        return round(8_000 * self.frame_bytes / self.technology.bit_rate_mbps)


class Outcomes(NamedTuple):
    """A row per frame and receiver, parallel to the pairs. Times in ns; -1: never arrives."""

    latency_ns: Ints
    arrived_ns: Ints
    outcome: NDArray[np.uint32]


def outcomes_of(
    pairs: Pairs,
    impairments: Impairments,
    sent_ns: int,
    deadline_ns: int,
    medium: OnAir,
    in_order: InOrder,
) -> Outcomes:
    """Return the outcome of one frame per source, sent at `sent_ns`.

    A frame that arrives by `deadline_ns` is part of the first delivery after it was sent.
    """
    on_air_ns = medium.frame_time_ns * turns(pairs, medium.technology.broadcast)
    gone = impairments.lost | impairments.damaged | impairments.collided | ~pairs.in_range
    arrived_ns = np.where(gone, -1, sent_ns + impairments.latency_ns + on_air_ns)
    if impairments.ordered.any():
        arrived_ns = in_order.held(pairs.source, pairs.destination, arrived_ns, impairments.ordered)
    outcome = np.where(arrived_ns <= deadline_ns, pb.OUTCOME_DELIVERED, pb.OUTCOME_LATE)
    outcome[impairments.damaged] = pb.OUTCOME_CORRUPTED
    outcome[impairments.collided] = pb.OUTCOME_COLLIDED
    outcome[impairments.lost] = pb.OUTCOME_LOST
    outcome[~pairs.in_range] = pb.OUTCOME_OUT_OF_RANGE
    latency_ns = np.where(gone, -1, arrived_ns - sent_ns)
    return Outcomes(latency_ns, arrived_ns, outcome.astype(np.uint32))


def turns(pairs: Pairs, broadcast: bool) -> Ints:
    """Return the number of each frame among the copies that its sender sends, from 1.

    A sender that cannot broadcast sends a copy to each receiver, the nearest one first.
    """
    turn = np.ones(len(pairs.source), dtype=np.int64)
    if broadcast:
        return turn
    order = np.lexsort((pairs.destination, pairs.distance, ~pairs.in_range, pairs.source))
    sources = pairs.source[order]
    first = np.searchsorted(sources, sources, side="left")
    turn[order] = np.arange(len(order)) - first + 1
    return turn
