"""The shared medium: how long stations wait, which frames collide, how busy the medium is."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.channel.babble import NO_BABBLE, Babble, Babblers
from zenvoy.channel.congestion import ReactiveDcc
from zenvoy.channel.csma import Backoffs, Hearing, aifs_ns, airtime_ns, contend
from zenvoy.channel.pairs import Pairs, pairs
from zenvoy.keyed_random.draws import Purpose, uniforms
from zenvoy.links.sent_frames import Scene, SentFrames
from zenvoy.scenarios import Scenario

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


_ALL: Final = np.uint64(2**64 - 1)


class Airing(NamedTuple):
    """How the frames of a cycle went over the air.

    wait_ns (n,): time from the instant at which a sender has its frame ready to the start of the
    transmission. collided (r,): by frame and receiver. busy_ratio (n,): share of the period in
    which a station senses others or sends.
    """

    wait_ns: Ints
    collided: Bools
    busy_ratio: Floats


class Access:
    """The medium of a scenario under carrier sense.

    Stations are not synchronised: each has its frame ready at an instant of its own within the
    cycle, drawn anew for each frame. That instant only decides which stations contend; latency
    counts from it. If a frame has not begun after a period, the next frame replaces it. A
    transmission that runs into the next cycle keeps stations of that cycle waiting, but does not
    collide with their frames.
    """

    def __init__(self, scenario: Scenario) -> None:
        channel, size = scenario.channel, scenario.fleet.size
        medium = channel.medium
        self._seed, self._size, self._period_ns = scenario.seed, size, scenario.period_ns
        self._range_m = medium.carrier_sense_m  # None: as far as frames are received
        self._space_ns = aifs_ns(medium.aifsn)
        self._backoffs = Backoffs(scenario.seed, medium.contention_window)
        self._babblers = Babblers(scenario)
        self._busy_until_ns = np.zeros(size + len(self._babblers), dtype=np.int64)
        self.on_air_ns = airtime_ns(channel.frame_bytes, channel.radio.bit_rate_mbps)
        """Time on the air of a frame."""
        self._dcc = ReactiveDcc(size) if medium.congestion_control == "reactive" else None

    def allowed(self, speaks: Bools, sent_ns: int) -> Bools:
        """Return which of the stations with a frame may send it under congestion control, (n,)."""
        return speaks if self._dcc is None else self._dcc.allowed(speaks, sent_ns)

    def air(
        self, frames: SentFrames, reach: Pairs, sends: Bools, sequence: Ints, scene: Scene
    ) -> Airing:
        """Send the frames of a cycle.

        reach: the pairs that are in range. sends, sequence: (n,).
        """
        senses = reach
        if self._range_m is not None:
            senses = pairs(scene.position, self._range_m, scene.ring_length_m)
        near = senses.only(senses.in_range)
        first = np.searchsorted(near.source, np.arange(self._size + 1))
        hearing = Hearing(first, near.destination)
        ready_ns = np.where(sends, scene.sent_ns + self._phase_ns(sequence), -1)
        start_ns, babble = self._contended(ready_ns, sequence, hearing, scene)
        airing = Airing(
            wait_ns=np.where(start_ns >= 0, start_ns - ready_ns, 0),
            collided=collided(frames, start_ns, hearing, self.on_air_ns, babble),
            busy_ratio=busy_ratio(start_ns, hearing, self.on_air_ns, self._period_ns, babble),
        )
        if self._dcc is not None:
            self._dcc.sensed(airing.busy_ratio)
        return airing

    def _contended(
        self, ready_ns: Ints, sequence: Ints, hearing: Hearing, scene: Scene
    ) -> tuple[Ints, Babble]:
        """Return when vehicles begin to send their frames, and what is sent without meaning."""
        size, queued, frames = self._size, {}, self._babblers.frames(scene.sent_ns)
        if frames.any():
            hearing = self._babblers.heard(hearing)
            ready_ns = np.concatenate([ready_ns, np.where(frames > 0, scene.sent_ns, -1)])
            sequence = np.concatenate([sequence, np.full(len(frames), scene.cycle)])
            queued = dict(enumerate(frames.tolist(), start=size))
        further: list[tuple[int, int]] = []
        start_ns = contend(
            ready_ns,
            sequence,
            hearing,
            self._busy_until_ns[: len(ready_ns)],
            self.on_air_ns,
            self._space_ns,
            self._period_ns,
            self._backoffs,
            queued,
            further,
        )
        if not queued:
            return start_ns, NO_BABBLE
        begun = np.flatnonzero(start_ns[size:] >= 0)
        station = np.concatenate([begun, [one - size for one, _ in further]]).astype(np.int64)
        starts_ns = np.concatenate([start_ns[size:][begun], [ns for _, ns in further]])
        index = self._babblers.vehicle_index[station]
        return start_ns[:size], Babble(index, starts_ns.astype(np.int64))

    def _phase_ns(self, sequence: Ints) -> Ints:
        stations = np.arange(1, self._size + 1)
        share, _ = uniforms(self._seed, Purpose.PHASE, stations, 0, sequence)
        return np.floor(share * self._period_ns).astype(np.int64)


def collided(
    frames: SentFrames,
    start_ns: Ints,
    hearing: Hearing,
    on_air_ns: int,
    babble: Babble = NO_BABBLE,
) -> Bools:
    """Return which frames their receivers miss because of other transmissions, (r,).

    Such a frame overlaps another one at its receiver, finds the receiver sending, or never began.
    start_ns (n,): -1 for stations that do not send. babble: what else is on the air.
    """
    n = len(start_ns)
    senders = np.flatnonzero(start_ns >= 0)
    without = np.zeros(len(babble.vehicle_index), np.bool_)
    means = np.concatenate([np.ones(len(senders), np.bool_), without])
    starts = np.concatenate([start_ns[senders], babble.start_ns])
    senders = np.concatenate([senders, babble.vehicle_index])
    order = np.argsort(starts, kind="stable")
    senders, starts, means = senders[order], starts[order], means[order]
    # All frames take the same time on the air, so the transmissions that overlap the k-th one are
    # its neighbours in order of start: low[k] to low[k] + count[k] - 1, k itself included.
    low = np.searchsorted(starts, starts - on_air_ns, side="right")
    count = np.searchsorted(starts, starts + on_air_ns, side="left") - low
    # A table with a row for each such pair: `other` overlaps `own`. The rows of k begin at
    # first[k].
    first = np.cumsum(count) - count
    own = np.repeat(np.arange(len(senders)), count)
    other = np.arange(len(own)) - first[own] + low[own]
    # The stations that each overlapping transmission deafens, as a set of bits. No transmission
    # disturbs itself.
    disturbs = _deafened(hearing, n)[senders[other]]
    disturbs[other == own] = 0
    # The union over the rows of k: the stations that cannot receive k. A station that does not
    # send reaches nobody.
    disturbed = np.full((n, disturbs.shape[1]), _ALL)
    if len(senders):
        disturbed[senders[means]] = np.bitwise_or.reduceat(disturbs, first, axis=0)[means]
    # Look up the bit of each frame's receiver: station d is bit d % 64 of word d // 64.
    word, bit = frames.destination >> 6, frames.destination & 63
    found: Bools = (disturbed[frames.source, word] >> bit.astype(np.uint64)) & np.uint64(1) > 0
    return found


def _deafened(hearing: Hearing, n: int) -> NDArray[np.uint64]:
    """Return the stations that cannot receive others while station i sends, as bits, (n, words).

    Station i itself is among them.
    """
    deaf = np.zeros((n, -(-n // 64) * 64), dtype=np.bool_)
    deaf[np.repeat(np.arange(n), np.diff(hearing.first)), hearing.stations] = True
    deaf[np.arange(n), np.arange(n)] = True
    return np.packbits(deaf, axis=1, bitorder="little").view("<u8").astype(np.uint64, copy=False)


def busy_ratio(
    start_ns: Ints,
    hearing: Hearing,
    on_air_ns: int,
    period_ns: int,
    babble: Babble = NO_BABBLE,
) -> Floats:
    """Return the share of a period in which each station senses others or sends, (n,).

    Transmissions that overlap count once.
    """
    n = len(start_ns)
    source = np.repeat(np.arange(n), np.diff(hearing.first))
    station = np.concatenate([hearing.stations, np.arange(n)])
    start = np.concatenate([start_ns[source], start_ns])
    for index, at_ns in zip(babble.vehicle_index.tolist(), babble.start_ns.tolist(), strict=True):
        senses = hearing.stations[hearing.first[index] : hearing.first[index + 1]]
        station = np.concatenate([station, senses, [index]])
        start = np.concatenate([start, np.full(len(senses) + 1, at_ns)])
    station, start = station[start >= 0], start[start >= 0]
    order = np.lexsort((start, station))
    station, start = station[order], start[order]
    until_next = np.diff(start, append=0)
    last = np.diff(station, append=-1) != 0
    busy = np.where(last, on_air_ns, np.minimum(until_next, on_air_ns))
    total = np.bincount(station, weights=busy, minlength=n)
    return np.minimum(total / period_ns, 1.0)
