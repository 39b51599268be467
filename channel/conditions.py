"""Loss and latency of each frame, by the channel's own sections and its rules."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.channel.latency import Latencies
from zenvoy.channel.loss import Losses
from zenvoy.channel.where import Where
from zenvoy.keyed_random.draws import Draws, Purpose, Seeds
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import Scenario

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Impairments(NamedTuple):
    """What impairs each frame at each receiver: loss, damage, collision, latency (ns).

    The latency does not include the time on the air. `ordered`: the frame must not overtake an
    earlier one on its link.
    """

    lost: Bools
    damaged: Bools
    collided: Bools
    latency_ns: Ints
    ordered: Bools


class Conditions:
    """Loss and latency of a scenario's channel, by link, time and stretch of road.

    The last rule that applies to a frame counts; if none does, the channel's own section counts.
    """

    def __init__(self, *scenarios: Scenario) -> None:
        """Take the scenarios of runs side by side, which differ only in their seed."""
        channel, size = scenarios[0].channel, scenarios[0].fleet.size
        seeds = Seeds(tuple(one.seed for one in scenarios), size)
        delay_ms = channel.radio.delay_ms
        losses = [channel.loss, *(rule.loss for rule in channel.rules)]
        latencies = [channel.latency, *(rule.latency for rule in channel.rules)]
        self._duplicate = channel.duplicate
        self._fates, self._copies = (
            Draws(seeds, purpose) for purpose in (Purpose.LOSS_AND_LATENCY, Purpose.DUPLICATION)
        )
        self._losses = {
            number: Losses(loss, seeds, number)
            for number, loss in enumerate(losses)
            if loss is not None
        }
        self._latencies = {
            number: Latencies(latency, delay_ms, seeds, number)
            for number, latency in enumerate(latencies)
            if latency is not None
        }
        self._where = {n: Where(rule, *scenarios) for n, rule in enumerate(channel.rules, start=1)}
        self._draws = any(model.draws for model in self._losses.values()) or any(
            model.draws for model in self._latencies.values()
        )

    @property
    def least_latency_ns(self) -> int:
        """The least latency that any section allows, without the time on the air."""
        return min(model.least_ns for model in self._latencies.values())

    @property
    def certain_latencies_ns(self) -> tuple[int, int] | None:
        """The least and the greatest latency, without the time on the air.

        None if a frame may be lost or damaged, if there are rules, or if the greatest latency is
        not known.
        """
        latency = self._latencies[0]
        if self._where or not self._losses[0].never or latency.greatest_ns is None:
            return None
        return latency.least_ns, latency.greatest_ns

    def of(self, frames: SentFrames, scene: Scene) -> Impairments:
        """Return what impairs each frame of a cycle."""
        count = len(frames.source)
        chance = share = np.zeros(count)
        if self._draws:
            chance, share = self._fates.of_links(*frames.link)
        covered = self._covered(frames, scene)
        lost, damaged = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
        for number, chosen in _portions(list(self._losses), covered, count):
            loss, some = self._losses[number], frames.only(chosen)
            lost[chosen] = loss.lost(some, scene, chance[chosen])
            damaged[chosen] = loss.damaged(some, scene)
        nothing = np.zeros(count, dtype=np.bool_)
        return Impairments(lost, damaged, nothing, *self._latency(frames, covered, share))

    def copies(self, frames: SentFrames, scene: Scene) -> tuple[Bools, Impairments]:
        """Return which of the frames come twice, and what impairs their second copies."""
        chance, share = self._copies.of_links(*frames.link)
        twice = chance < self._duplicate
        some = frames.only(twice)
        nothing = np.zeros(len(some.source), dtype=np.bool_)
        covered = self._covered(some, scene)
        return twice, Impairments(
            nothing, nothing, nothing, *self._latency(some, covered, share[twice])
        )

    def _latency(
        self, frames: SentFrames, covered: dict[int, Bools], share: Floats
    ) -> tuple[Ints, Bools]:
        latency_ns = np.zeros(len(share), dtype=np.int64)
        ordered = np.zeros(len(share), dtype=np.bool_)
        for number, chosen in _portions(list(self._latencies), covered, len(share)):
            latency = self._latencies[number]
            latency_ns[chosen] = latency.of(frames.only(chosen), share[chosen])
            ordered[chosen] = latency.ordered
        return latency_ns, ordered

    def _covered(self, frames: SentFrames, scene: Scene) -> dict[int, Bools]:
        """Return the rows to which each rule applies, by the number of the rule."""
        found = {
            number: where.covers(frames.source, frames.destination, scene.position, scene.sent_ns)
            for number, where in self._where.items()
        }
        return {number: mask for number, mask in found.items() if mask is not None}


def _portions(
    numbers: list[int], covered: dict[int, Bools], rows: int
) -> Iterator[tuple[int, Bools | slice]]:
    """Yield the number and the rows of each section that has rows."""
    if rows and not covered:  # the usual case: a slice copies nothing
        yield 0, slice(None)
        return
    owner = np.zeros(rows, dtype=np.int64)
    for number in numbers:
        if number in covered:
            owner[covered[number]] = number
    for number in numbers:
        chosen = owner == number
        if chosen.any():
            yield number, chosen
