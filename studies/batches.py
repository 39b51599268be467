"""Runs on arrays as values for the analysis, without a log."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.load import Run, in_memory
from zenvoy.analysis.log.reading import TABLES
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Log
from zenvoy.bus.log_format import Fingerprint
from zenvoy.bus.topics import CLOCK, ESTIMATE, FLEET_COMMAND, RADAR, TRUTH, Topic
from zenvoy.fleet.arrays.batch import Batch, Cycle
from zenvoy.fleet.arrays.columns import Column, columns_of, needs_whole
from zenvoy.fleet.arrays.happenings import Happenings
from zenvoy.fleet.arrays.log import RunLog
from zenvoy.fleet.labels import metadata_without_log
from zenvoy.scenarios import Loaded, Scenario

Wanted = Mapping[str, Sequence[str]]
"""Columns by topic: `{"/fleet/truth": ["position", "speed"]}`."""

Columns = dict[str, dict[str, Column]]

LIMIT_BYTES: Final = 320 << 20
"""Memory for the columns of a batch: the digests of 30 runs of the paper need 282 MiB."""

_DTYPES: Final = {
    topic: codec.fields() for topic, codec in TABLES.items() if topic != CLOCK.log_name
}


def run_batch(
    runs: Sequence[Loaded],
    wanted: Wanted,
    *,
    fingerprints: bool = False,
    limit_bytes: int = LIMIT_BYTES,
) -> Iterator[Run]:
    """Yield the runs of scenarios that differ only in their seed, in their order.

    Their tables have `cycle`, `time_ns` and the wanted columns. Tables and events have the same
    bits as in a log of the in-process bus. The runs are split into batches whose columns take at
    most `limit_bytes`, or into single runs. A batch is freed when none of its runs is used any
    more. With `fingerprints`, each run gets its fingerprint. This makes every message of a log, and
    takes many times as long.

    Raises ValueError for a column that these runs do not have, LawError if a law fails, and
    NotCoveredError if a law fails only on arrays.
    """
    columns = _wanted([loaded.scenario for loaded in runs], wanted)
    for some in parts(runs, wanted, limit_bytes):
        yield from _one_batch(some, columns, fingerprints)


def parts(
    runs: Sequence[Loaded], wanted: Wanted, limit_bytes: int = LIMIT_BYTES
) -> list[Sequence[Loaded]]:
    """Return the runs in parts of about equal size, each within the limit if it can be."""
    most = max(1, limit_bytes // bytes_of_run(runs[0].scenario, wanted))
    count = math.ceil(len(runs) / most)
    return [
        runs[part * len(runs) // count : (part + 1) * len(runs) // count] for part in range(count)
    ]


def bytes_of_run(scenario: Scenario, wanted: Wanted) -> int:
    """Return the memory that the wanted columns of a run take, in bytes."""
    values = sum(_dtype(topic, name).itemsize for topic, names in wanted.items() for name in names)
    return (scenario.cycles + 1) * (scenario.fleet.size * values + 12 * len(_DTYPES))


def _wanted(scenarios: Sequence[Scenario], wanted: Wanted) -> Columns:
    """Return the wanted columns. A seed may decide whether a fleet has MBCM, and so its columns."""
    known: Columns = {}
    for scenario in scenarios:
        for topic, columns in columns_of(scenario).items():
            known.setdefault(topic, {}).update(columns)
    for topic, names in wanted.items():
        for name in names:
            if name not in known.get(topic, ()):
                raise ValueError(f"{topic}: these runs have no column {name}")
    return {topic: {name: known[topic][name] for name in wanted.get(topic, ())} for topic in known}


def _dtype(topic: str, name: str) -> np.dtype[np.generic]:
    """Return the type of a column, as in a log; laws log float64."""
    fields = _DTYPES[topic]
    return fields[name][0] if name in fields else np.dtype(np.float64)


def _one_batch(runs: Sequence[Loaded], columns: Columns, fingerprints: bool) -> Iterator[Run]:
    scenario = runs[0].scenario
    whole = fingerprints or any(
        needs_whole(topic, name) for topic, names in columns.items() for name in names
    )
    batch = Batch([loaded.scenario for loaded in runs], whole=whole)
    prints = [Fingerprint() for _ in runs] if fingerprints else []
    logs = [RunLog(batch, run, _into(one)) for run, one in enumerate(prints)]
    filled = _Filled(scenario, len(runs), columns)
    happenings = Happenings(scenario, len(runs))
    events: list[list[pb.Event]] = [[] for _ in runs]

    def step(time_ns: int, collided: Sequence[tuple[int, int]], *, over: bool = False) -> None:
        for run, entries in happenings.step(time_ns, collided, over=over).items():
            events[run] += [pb.Event.FromString(entry.payload) for entry in entries]

    for cycle in batch.cycles():
        time_ns = cycle.number * scenario.period_ns
        filled.take(cycle)
        for log in logs:
            log.take(cycle)
        step(time_ns, cycle.collided)
        if cycle.decisions is not None:
            happenings.decide(cycle.decisions.mode, time_ns + scenario.v2v_wait_ns)
        else:
            for _ in range(happenings.lookahead + 1):
                step(time_ns, (), over=True)
        if happenings.all_stopped:
            break
    for run, loaded in enumerate(runs):
        stopped_ns = happenings.stopped.get(run)
        yield in_memory(
            loaded.scenario,
            metadata_without_log(loaded),
            end="complete",
            tables=filled.tables(
                run,
                columns_of(loaded.scenario),
                None if stopped_ns is None else stopped_ns // scenario.period_ns,
                happenings.lookahead,
            ),
            events=events[run],
            fingerprint=prints[run].hexdigest() if fingerprints else None,
        )


def _into(fingerprint: Fingerprint) -> Log:
    def add(topic: Topic[Any], time_ns: int, payload: bytes) -> None:
        fingerprint.add(topic.log_name, time_ns, payload)

    return add


class _Filled:
    """The columns of all runs of a batch, (runs, rows, n), which are filled cycle by cycle."""

    def __init__(self, scenario: Scenario, runs: int, columns: Columns) -> None:
        self._columns = columns
        self._cycles = scenario.cycles
        self._shape = (runs, scenario.fleet.size)
        self._values: dict[str, dict[str, NDArray[Any]]] = {
            topic: {
                name: np.empty((runs, self._rows(topic), scenario.fleet.size), _dtype(topic, name))
                for name in names
            }
            for topic, names in columns.items()
        }
        number = np.arange(scenario.cycles + 1)
        self._cycle = number.astype(_dtype(TRUTH.log_name, "cycle"))
        self._start_ns = number * scenario.period_ns
        self._wait_ns = scenario.v2v_wait_ns

    def take(self, cycle: Cycle) -> None:
        """Fill the rows of a cycle; after the last cycle only truth has a row."""
        for topic, names in self._columns.items():
            if cycle.number < self._rows(topic):
                for name, column in names.items():
                    values = column(cycle).reshape(self._shape)
                    self._values[topic][name][:, cycle.number] = values

    def tables(
        self, run: int, its: Columns, stopped: int | None, lookahead: int
    ) -> dict[str, Table]:
        """Return the tables of a run, of which `its` are the columns that its log would have.

        stopped is the cycle in which a collision has ended the run. Its log has only the decisions
        that the world has received by then.
        """
        last = self._cycles if stopped is None else stopped
        decided = last if stopped is None else max(0, last - lookahead)
        rows = {
            TRUTH.log_name: last + 1,
            RADAR.log_name: last,
            ESTIMATE.log_name: decided,
            FLEET_COMMAND.log_name: decided,
        }
        return {topic: self._table(topic, run, its[topic], count) for topic, count in rows.items()}

    def _table(self, topic: str, run: int, its: Mapping[str, Column], rows: int) -> Table:
        if not rows:
            return {}
        wait_ns = self._wait_ns if topic in {ESTIMATE.log_name, FLEET_COMMAND.log_name} else 0
        table: Table = {"cycle": self._cycle[:rows], "time_ns": self._start_ns[:rows] + wait_ns}
        for name, values in self._values[topic].items():
            table[name] = values[run, :rows] if name in its else values[run, :rows, :0]
        return table

    def _rows(self, topic: str) -> int:
        return self._cycles + (topic == TRUTH.log_name)
