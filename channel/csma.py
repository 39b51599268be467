"""Carrier sense multiple access: when each station of a cycle gets the medium, and what it hears.

As IEEE 802.11's EDCA does for broadcasts, which are sent once and never acknowledged: a station
that finds the medium idle for AIFS sends; one that finds it busy waits for its end, AIFS, and a
number of slots drawn from the contention window. A transmission is sensed a slot after it began,
so two may begin within one.
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Purpose, uniforms

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# In 10 MHz channels (IEEE 802.11-2016, clause 17; ETSI EN 302 663): times in ns.
SLOT_NS: Final = 13_000
SIFS_NS: Final = 32_000
PREAMBLE_NS: Final = 40_000  # with the SIGNAL field
SYMBOL_NS: Final = 8_000
_SERVICE_AND_TAIL_BITS: Final = 22
_BLOCK: Final = 8  # backoffs that are drawn together
_SENSED, _TRIES = 0, 1  # at one instant, what is on the air is sensed before others try


class Hearing(NamedTuple):
    """Who senses whom: stations[first[i]:first[i + 1]] are those that sense station i."""

    first: Ints
    stations: Ints


def airtime_ns(frame_bytes: int, bit_rate_mbps: float) -> int:
    """Time on the air of a frame in a 10 MHz channel: preamble, SIGNAL, and whole symbols."""
    bits_per_symbol = bit_rate_mbps * SYMBOL_NS / 1_000
    symbols = -(-(_SERVICE_AND_TAIL_BITS + 8 * frame_bytes) // bits_per_symbol)
    return PREAMBLE_NS + int(symbols) * SYMBOL_NS


def aifs_ns(number: int) -> int:
    """Arbitration inter-frame space of an AIFSN."""
    return SIFS_NS + number * SLOT_NS


class Backoffs:
    """Slots that stations wait, keyed by seed, station, frame and try."""

    def __init__(self, seed: int, window: int) -> None:
        self._seed, self._slots = seed, window + 1
        self._drawn: dict[tuple[int, int, int], list[int]] = {}

    def slots(self, station: int, sequence: int, attempt: int) -> int:
        """Of a try, from 0 to the contention window, for the station of that index."""
        block, at = divmod(attempt, _BLOCK)
        key = (station, sequence, block)
        if key not in self._drawn:
            numbers = np.arange(block * _BLOCK, (block + 1) * _BLOCK)
            draws, _ = uniforms(self._seed, Purpose.BACKOFF, station + 1, numbers, sequence)
            self._drawn[key] = np.floor(draws * self._slots).astype(np.int64).tolist()
        return self._drawn[key][at]

    def draw(self, stations: Ints, sequences: Ints) -> None:
        """Draw the first tries of all of these at once: one by one costs 50 times as much."""
        numbers = np.arange(_BLOCK)
        keys = (stations[:, None] + 1, numbers, sequences[:, None])
        draws, _ = uniforms(self._seed, Purpose.BACKOFF, *keys)
        slots = np.floor(draws * self._slots).astype(np.int64).tolist()
        for key, row in zip(
            zip(stations.tolist(), sequences.tolist(), strict=True), slots, strict=True
        ):
            self._drawn[*key, 0] = row

    def forget(self) -> None:
        """Drop what was drawn for frames that have been sent."""
        self._drawn.clear()


def contend(
    ready_ns: Ints,
    sequence: Ints,
    hearing: Hearing,
    busy_until_ns: Ints,
    on_air_ns: int,
    space_ns: int,
    patience_ns: int,
    backoffs: Backoffs,
) -> Ints:
    """When each station begins to send, ns, (n,); -1 for those that are not ready (ready_ns -1).

    -1 too for those that could not within `patience_ns`: a newer frame has taken the place of
    theirs. `busy_until_ns` (n,): until when each senses the medium busy; it is moved on.
    """
    # A simulation by events in order of time. At _TRIES a station looks at the medium: it begins to
    # send, or it tries again after the transmission that it senses, AIFS and its backoff. At
    # _SENSED, a slot after a begin, all who are in reach learn until when the medium is busy.
    start_ns = np.full(len(ready_ns), -1, dtype=np.int64)
    ready = np.flatnonzero(ready_ns >= 0)
    whens = (ready_ns[ready] + space_ns).tolist()
    events = [(ns, _TRIES, i) for i, ns in zip(ready.tolist(), whens, strict=True)]
    heapify(events)
    tries = [0] * len(ready_ns)
    last_ns = (ready_ns + patience_ns).tolist()
    first, stations = hearing.first.tolist(), hearing.stations
    numbers = sequence.tolist()
    backoffs.draw(ready, sequence[ready])
    while events:
        now_ns, kind, i = heappop(events)
        if kind == _SENSED:
            who = stations[first[i] : first[i + 1]]
            end_ns = now_ns - SLOT_NS + on_air_ns
            busy_until_ns[who] = np.maximum(busy_until_ns[who], end_ns)
            continue
        free_ns = int(busy_until_ns[i])
        if free_ns > now_ns:
            wait_ns = space_ns + SLOT_NS * backoffs.slots(i, numbers[i], tries[i])
            tries[i] += 1
            if free_ns + wait_ns <= last_ns[i]:  # else the frame is given up
                heappush(events, (free_ns + wait_ns, _TRIES, i))
            continue
        start_ns[i] = now_ns
        heappush(events, (now_ns + SLOT_NS, _SENSED, i))
    backoffs.forget()
    return start_ns
