"""Everything that the channel of a scenario does to the frames of a cycle, step by step."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.channel.access import Access
from zenvoy.channel.conditions import Conditions, Impairments
from zenvoy.channel.frames import OnAir, Outcomes, outcomes_of
from zenvoy.channel.in_order import InOrder
from zenvoy.channel.outages import Outages
from zenvoy.channel.pairs import Pairs, pairs
from zenvoy.channel.relay import Hop, relay
from zenvoy.keyed_random.draws import Draws, Purpose, Seeds
from zenvoy.links.distance import distance
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import Scenario

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Transmitted(NamedTuple):
    """The frames of a cycle and their outcomes, in parallel rows.

    hops (r,): number of links that a frame crossed; None if the channel does not relay.
    busy_ratio (n,): share of time in which each vehicle sensed the medium busy; None without
    carrier sense.
    """

    frames: SentFrames
    outcomes: Outcomes
    hops: Ints | None
    busy_ratio: Floats | None


class Transmission:
    """The channel of a scenario, with the states of its links."""

    def __init__(self, scenario: Scenario) -> None:
        channel = scenario.channel
        self._size = scenario.fleet.size
        self._access = Access(scenario) if channel.medium.access == "csma" else None
        self._medium = OnAir(
            technology=channel.radio,
            frame_bytes=channel.frame_bytes,
            on_air_ns=None if self._access is None else self._access.on_air_ns,
        )
        self._conditions = Conditions(scenario)
        self._outages = Outages(scenario)
        self._by_hand = Draws(Seeds((scenario.seed,), self._size), Purpose.LOSS_BY_HAND)
        self._in_order = InOrder(self._size)
        self._duplicates = channel.duplicate > 0.0
        self._relay_hops = channel.relay_hops
        wait_ns = scenario.v2v_wait_ns
        # From sending to the first delivery after it.
        self._in_time_ns = wait_ns if wait_ns else scenario.period_ns

    @property
    def least_latency_ns(self) -> int:
        """The least time from sending a frame to its arrival."""
        return self._conditions.least_latency_ns + self._medium.frame_time_ns

    def of(
        self, speaks: Bools, sequence: Ints, scene: Scene, loss_by_hand: float = 0.0
    ) -> Transmitted:
        """Send a frame of each vehicle that `speaks`, (n,), with number `sequence`, (n,).

        loss_by_hand: the share of frames that are lost besides those that the scenario loses.
        """
        reach = pairs(scene.position, self._medium.technology.range_m, scene.ring_length_m)
        sends = speaks if self._access is None else self._access.allowed(speaks, scene.sent_ns)
        everyone = reach
        if not sends.all():
            reach = reach.only(sends[reach.source])
        frames = SentFrames(reach.source, reach.destination, reach.distance, sequence[reach.source])
        impairments = self._conditions.of(frames, scene)
        outages = self._outages.lost(
            frames.source, frames.destination, scene.position, scene.sent_ns
        )
        if outages is not None:
            impairments = impairments._replace(lost=impairments.lost | outages)
        if loss_by_hand > 0.0:
            chance, _ = self._by_hand.of_links(*frames.link)
            impairments = impairments._replace(lost=impairments.lost | (chance < loss_by_hand))
        busy_ratio = hops = None
        if self._access is not None:
            airing = self._access.air(frames, everyone, sends, sequence, scene)
            latency_ns = impairments.latency_ns + airing.wait_ns[frames.source]
            impairments = impairments._replace(latency_ns=latency_ns, collided=airing.collided)
            busy_ratio = airing.busy_ratio
        outcomes = self._outcomes(reach, impairments, scene)
        if self._duplicates:
            frames, outcomes = self._with_copies(reach, frames, outcomes, scene)
        if self._relay_hops > 1:
            frames, outcomes, hops = self._with_relayed(frames, outcomes, sequence, scene)
        return Transmitted(frames, outcomes, hops, busy_ratio)

    def _outcomes(self, reach: Pairs, impairments: Impairments, scene: Scene) -> Outcomes:
        deadline_ns = scene.sent_ns + self._in_time_ns
        return outcomes_of(
            reach, impairments, scene.sent_ns, deadline_ns, self._medium, self._in_order
        )

    def _with_copies(
        self, reach: Pairs, frames: SentFrames, outcomes: Outcomes, scene: Scene
    ) -> tuple[SentFrames, Outcomes]:
        """Append the second copies of some of the frames that arrive."""
        through = outcomes.arrived_ns >= 0
        twice, impairments = self._conditions.copies(frames.only(through), scene)
        through[through] = twice
        copies = self._outcomes(reach.only(through), impairments, scene)
        copies.outcome[:] = pb.OUTCOME_DUPLICATE
        return _below(frames, outcomes, frames.only(through), copies)

    def _with_relayed(
        self, frames: SentFrames, outcomes: Outcomes, sequence: Ints, scene: Scene
    ) -> tuple[SentFrames, Outcomes, Ints]:
        """Append the frames that other vehicles have passed on; also return the hops of each."""
        first = (outcomes.outcome != pb.OUTCOME_OUT_OF_RANGE) & (
            outcomes.outcome != pb.OUTCOME_DUPLICATE
        )
        direct = Hop(frames.source[first], frames.destination[first], outcomes.latency_ns[first])
        relayed = relay(direct, self._size, self._relay_hops)
        ends = (relayed.source, relayed.destination)
        source, destination = (scene.position[end] for end in ends)
        apart = distance(source, destination, scene.ring_length_m)
        passed_on = SentFrames(*ends, apart, sequence[relayed.source])
        arrives = relayed.latency_ns >= 0
        arrived_ns = np.where(arrives, scene.sent_ns + relayed.latency_ns, -1)
        in_time = relayed.latency_ns <= self._in_time_ns
        outcome = np.where(in_time, pb.OUTCOME_DELIVERED, pb.OUTCOME_LATE)
        outcome[~arrives] = pb.OUTCOME_LOST
        # These pairs already have a row with outcome out of range, which is no longer true.
        code = frames.source * self._size + frames.destination
        kept = ~np.isin(code, ends[0] * self._size + ends[1])
        some = Outcomes(relayed.latency_ns, arrived_ns, outcome.astype(np.uint32))
        hops = np.concatenate([np.ones(int(kept.sum()), dtype=np.int64), relayed.hops])
        outcomes = Outcomes._make(column[kept] for column in outcomes)
        return (*_below(frames.only(kept), outcomes, passed_on, some), hops)


def _below(
    frames: SentFrames, outcomes: Outcomes, more_frames: SentFrames, more_outcomes: Outcomes
) -> tuple[SentFrames, Outcomes]:
    """Append the second table to the first."""
    return SentFrames._make(_joined(frames, more_frames)), Outcomes._make(
        _joined(outcomes, more_outcomes)
    )


def _joined(
    first: tuple[NDArray[Any], ...], second: tuple[NDArray[Any], ...]
) -> list[NDArray[Any]]:
    """Join each column of the first table with that of the second."""
    return [np.concatenate(pair) for pair in zip(first, second, strict=True)]
