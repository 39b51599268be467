"""Turns the messages of a cycle into what the page shows of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from math import nan
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import CLOCK, ESTIMATE, FLEET_COMMAND, FRAMES, RADAR, TRUTH
from zenvoy.links.distance import gaps

Table = dict[str, NDArray[Any]]

COLUMNS: Final = {
    "speed": "m/s",
    "acceleration": "m/s²",
    "command": "m/s²",
    "gap": "m",
    "read_gap": "m",
    "estimated_gap": "m",
    "gap_std": "m",
    "read_speed": "m/s",
    "estimated_speed": "m/s",
    "age": "s",
    "mode": "",
    "heard": "frames",
    "missed": "frames",
}
"""What the page knows of each vehicle in each cycle besides its position, and in which unit.

`gap` is the true one. `heard` and `missed` count the frames of the cycle that others have sent.
"""
TOTALS: Final = {
    "mean_speed": "m/s",
    "smallest_gap": "m",
    "oldest": "s",
    "delivered": "frames",
    "late": "frames",
    "lost": "frames",
    "collided": "frames",
    "busy": "",
    "busiest": "",
    "wall": "s",
}
"""What the page knows of the fleet in each cycle. `late` frames are delivered by a later cycle."""

_CODECS: Final = {
    topic.log_name: PackedCodec(topic.message.DESCRIPTOR)
    for topic in (TRUTH, RADAR, ESTIMATE, FLEET_COMMAND, FRAMES, CLOCK)
}
_HEARD: Final = (pb.OUTCOME_DELIVERED, pb.OUTCOME_LATE)
_LOST: Final = (pb.OUTCOME_LOST, pb.OUTCOME_CORRUPTED)
_MISSED: Final = (*_LOST, pb.OUTCOME_COLLIDED)


class Picture(NamedTuple):
    """A cycle: positions (n,), m; COLUMNS as (columns, n), and TOTALS as (totals,)."""

    position: NDArray[np.float64]
    columns: NDArray[np.float32]
    totals: NDArray[np.float32]


class Rows(NamedTuple):
    """Frames, a row for each receiver; times in s, -1 where a frame never arrives."""

    cycle: NDArray[np.uint32]
    source: NDArray[np.uint32]
    destination: NDArray[np.uint32]
    outcome: NDArray[np.uint32]
    sent: NDArray[np.float64]
    arrived: NDArray[np.float64]


def picture_of(
    payloads: Mapping[str, Sequence[memoryview]], vehicles: int, ring_length_m: float | None
) -> Picture | None:
    """Return the picture of a cycle from its messages; None without the truth.

    Messages with the wrong number of vehicles, or that cannot be read, count as absent.
    """
    tables = {
        topic: table
        for topic in _CODECS
        if topic != FRAMES.log_name and (table := _table(payloads, topic, vehicles)) is not None
    }
    truth = tables.get(TRUTH.log_name)
    if truth is None:
        return None
    radar, estimate = tables.get(RADAR.log_name, {}), tables.get(ESTIMATE.log_name, {})
    command, clock = tables.get(FLEET_COMMAND.log_name, {}), tables.get(CLOCK.log_name, {})
    frames = frames_of(payloads)
    outcomes = _outcomes(frames, vehicles)
    gap = gaps(truth["position"], ring_length_m)
    age = _seconds(estimate.get("age_ns"), vehicles)
    columns = np.full((len(COLUMNS), vehicles), nan, np.float32)
    values = {
        "speed": truth["speed"],
        "acceleration": truth["acceleration"],
        "command": command.get("acceleration"),
        "gap": gap,
        "read_gap": radar.get("gap"),
        "estimated_gap": estimate.get("ahead_gap"),
        "gap_std": estimate.get("ahead_gap_std"),
        "read_speed": radar.get("speed"),
        "estimated_speed": estimate.get("speed"),
        "age": age,
        "mode": estimate.get("mode"),
        "heard": _received(outcomes, _HEARD),
        "missed": _received(outcomes, _MISSED),
    }
    for row, name in enumerate(COLUMNS):
        value = values[name]
        if value is not None and len(value) == vehicles:
            columns[row] = value
    totals = _totals(truth, gap, age, outcomes, frames, clock)
    return Picture(truth["position"], columns, np.array(totals, np.float32))


def rows_of(
    cycles: Mapping[int, Mapping[str, Sequence[memoryview]]], who: Collection[int], *, ring: int
) -> Rows:
    """Return the frames of these cycles that vehicles of `who` send or receive.

    If `who` is empty, it returns the frames between neighbours. On a ring of `ring` vehicles the
    first and the last are neighbours, too; 0: the road is no ring.
    """
    found: list[tuple[int, Table]] = []
    chosen = np.array(sorted(who), np.uint32)
    for cycle in sorted(cycles):
        for table in frames_of(cycles[cycle]):
            source, destination = table["source"], table["destination"]
            if len(chosen):
                mask = np.isin(source, chosen) | np.isin(destination, chosen)
            else:
                apart = np.abs(source.astype(np.int64) - destination.astype(np.int64))
                mask = np.isin(apart, (1, ring - 1))
            found.append((cycle, {name: table[name][mask] for name in _ROW_FIELDS}))

    def column(name: str, dtype: type) -> NDArray[Any]:
        parts = [table[name] for _, table in found]
        return np.concatenate([np.zeros(0, dtype), *parts]).astype(dtype)

    return Rows(
        cycle=np.repeat(
            np.array([cycle for cycle, _ in found], np.uint32),
            [len(table["source"]) for _, table in found],
        ),
        source=column("source", np.uint32),
        destination=column("destination", np.uint32),
        outcome=column("outcome", np.uint32),
        sent=column("sent_ns", np.float64) * 1e-9,
        arrived=np.where((late := column("arrived_ns", np.float64)) < 0, -1.0, late * 1e-9),
    )


def frames_of(payloads: Mapping[str, Sequence[memoryview]]) -> list[Table]:
    """Return the frames of a cycle; in real time they may come in several messages."""
    found = []
    for payload in payloads.get(FRAMES.log_name, ()):
        try:
            table = _CODECS[FRAMES.log_name].decode(payload)
        except ValueError:
            continue
        if len({len(table[name]) for name in _ROW_FIELDS}) == 1:
            found.append(table)
    return found


_ROW_FIELDS: Final = ("source", "destination", "outcome", "sent_ns", "arrived_ns")


def _table(payloads: Mapping[str, Sequence[memoryview]], topic: str, vehicles: int) -> Table | None:
    """Return the last message of a topic with as many numbers as vehicles in its columns."""
    for payload in reversed(payloads.get(topic, ())):
        try:
            table = _CODECS[topic].decode(payload)
        except ValueError:
            continue
        if topic == CLOCK.log_name or all(
            column.ndim == 0 or len(column) in {0, vehicles} or name == "logged"
            for name, column in table.items()
        ):
            return table if topic != TRUTH.log_name or len(table["position"]) else None
    return None


def _seconds(value_ns: NDArray[Any] | None, vehicles: int) -> NDArray[np.float64]:
    """Return times in s; NaN for -1, which stands for none."""
    if value_ns is None or len(value_ns) != vehicles:
        return np.full(vehicles, nan)
    return np.where(value_ns < 0, nan, value_ns * 1e-9)


def _outcomes(frames: Sequence[Table], vehicles: int) -> NDArray[np.int64] | None:
    """Return how many frames of each outcome there are for each receiver, (n, 8)."""
    if not frames:
        return None
    counts = np.zeros((vehicles + 2) * 8, np.int64)
    for table in frames:
        to = np.minimum(table["destination"], vehicles + 1).astype(np.int64)  # who does not exist
        counts += np.bincount(to * 8 + np.minimum(table["outcome"], 7), minlength=len(counts))
    return counts.reshape(-1, 8)[1:-1]


def _received(
    outcomes: NDArray[np.int64] | None, which: tuple[int, ...]
) -> NDArray[np.int64] | None:
    if outcomes is None:
        return None
    received: NDArray[np.int64] = outcomes[:, which].sum(axis=1)
    return received


def _totals(
    truth: Table,
    gap: NDArray[Any],
    age: NDArray[Any],
    outcomes: NDArray[np.int64] | None,
    frames: Sequence[Table],
    clock: Table,
) -> list[float]:
    """Return TOTALS in their order."""
    sums = np.full(8, nan) if outcomes is None else outcomes.sum(axis=0)
    busy = [table["busy_ratio"] for table in frames if len(table["busy_ratio"])]
    shares = np.concatenate(busy) if busy else np.array([nan])
    return [
        float(truth["speed"].mean()),
        float(np.nanmin(gap, initial=np.inf)),
        float(np.nanmax(age, initial=-1.0)),
        float(sums[pb.OUTCOME_DELIVERED]),
        float(sums[pb.OUTCOME_LATE]),
        float(sum(sums[one] for one in _LOST)),
        float(sums[pb.OUTCOME_COLLIDED]),
        float(shares.mean()),
        float(shares.max()),
        float(clock["wall_ns"]) * 1e-9 if clock else nan,
    ]
