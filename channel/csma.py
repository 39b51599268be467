"""Carrier sense multiple access: when each station gets the medium in a cycle.

This is EDCA of IEEE 802.11 for broadcasts, which are sent once and never acknowledged. A station
that finds the medium idle for AIFS sends. A station that finds it busy waits until it is idle, then
for AIFS and a number of slots drawn from the contention window. Others sense a transmission one
slot after it begins, so two transmissions may begin within one slot.
"""

from __future__ import annotations

from collections.abc import Mapping
from heapq import heapify, heappop, heappush
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Purpose, uniforms

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Times in 10 MHz channels, ns (IEEE 802.11-2016, clause 17; ETSI EN 302 663).
SLOT_NS: Final = 13_000
SIFS_NS: Final = 32_000
PREAMBLE_NS: Final = 40_000  # with the SIGNAL field
SYMBOL_NS: Final = 8_000
_SERVICE_AND_TAIL_BITS: Final = 22
_BLOCK: Final = 8  # backoffs that are drawn together
_SENSED, _TRIES = 0, 1  # at equal times, stations sense a transmission before others try


class Hearing(NamedTuple):
    """Which stations sense which: stations[first[i]:first[i + 1]] sense station i."""

    first: Ints
    stations: Ints


def airtime_ns(frame_bytes: int, bit_rate_mbps: float) -> int:
    """Return the time on the air of a frame, ns: preamble, SIGNAL and whole symbols at 10 MHz."""
    bits_per_symbol = bit_rate_mbps * SYMBOL_NS / 1_000
    symbols = -(-(_SERVICE_AND_TAIL_BITS + 8 * frame_bytes) // bits_per_symbol)
    return PREAMBLE_NS + int(symbols) * SYMBOL_NS


def aifs_ns(number: int) -> int:
    """Return the arbitration inter-frame space of an AIFSN."""
    return SIFS_NS + number * SLOT_NS


class Backoffs:
    """Backoffs in slots, drawn by seed, station, frame and try."""

    def __init__(self, seed: int, window: int) -> None:
        self._seed, self._slots = seed, window + 1
        self._drawn: dict[tuple[int, int, int], list[int]] = {}

    def slots(self, station: int, sequence: int, attempt: int) -> int:
        """Return the backoff of one try, from 0 to the contention window; station: its index."""
        block, at = divmod(attempt, _BLOCK)
        key = (station, sequence, block)
        if key not in self._drawn:
            numbers = np.arange(block * _BLOCK, (block + 1) * _BLOCK)
            draws, _ = uniforms(self._seed, Purpose.BACKOFF, station + 1, numbers, sequence)
            self._drawn[key] = np.floor(draws * self._slots).astype(np.int64).tolist()
        return self._drawn[key][at]

    def draw(self, stations: Ints, sequences: Ints) -> None:
        """Draw the first tries of these stations at once; one by one takes 50 times as long."""
        numbers = np.arange(_BLOCK)
        keys = (stations[:, None] + 1, numbers, sequences[:, None])
        draws, _ = uniforms(self._seed, Purpose.BACKOFF, *keys)
        slots = np.floor(draws * self._slots).astype(np.int64).tolist()
        for key, row in zip(
            zip(stations.tolist(), sequences.tolist(), strict=True), slots, strict=True
        ):
            self._drawn[*key, 0] = row

    def forget(self) -> None:
        """Drop the draws of frames that have been sent."""
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
    queued: Mapping[int, int] = MappingProxyType({}),
    further: list[tuple[int, int]] | None = None,
) -> Ints:
    """Return when each station begins to send, ns, (n,); -1 if it does not send.

    A station with `queued` frames sends as many one after the other. All its starts but the first
    are appended to `further`, as station and ns.

    A station does not send if it is not ready (ready_ns -1), or if it cannot begin within
    `patience_ns`: then a newer frame replaces its own. `busy_until_ns` (n,), until when each
    station senses the medium busy, is updated in place.
    """
    # A simulation of events in order of time. At _TRIES a station senses the medium: it begins to
    # send, or it tries again after the transmission that it senses, AIFS and its backoff. At
    # _SENSED, a slot after a start, all stations in reach learn until when the medium is busy.
    start_ns = np.full(len(ready_ns), -1, dtype=np.int64)
    ready = np.flatnonzero(ready_ns >= 0)
    whens = (ready_ns[ready] + space_ns).tolist()
    events = [(ns, _TRIES, i) for i, ns in zip(ready.tolist(), whens, strict=True)]
    heapify(events)
    tries = [0] * len(ready_ns)
    last_ns = (ready_ns + patience_ns).tolist()
    left, later = dict(queued), [] if further is None else further
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
        if start_ns[i] < 0:
            start_ns[i] = now_ns
        else:
            later.append((i, now_ns))
        heappush(events, (now_ns + SLOT_NS, _SENSED, i))
        if left.get(i, 1) > 1:
            left[i] -= 1
            next_ns = now_ns + on_air_ns + space_ns
            next_ns += SLOT_NS * backoffs.slots(i, numbers[i], tries[i])
            tries[i] += 1
            if next_ns <= last_ns[i]:
                heappush(events, (next_ns, _TRIES, i))
    backoffs.forget()
    return start_ns
