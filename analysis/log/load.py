"""Loads a run's log as one value, for notebooks and for every chapter of a report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.arrays import read_frames
from zenvoy.analysis.log.checks import Check
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.facts import Facts
from zenvoy.analysis.log.laws import LoggedLaw, laws_in, own_laws_in, units_of
from zenvoy.analysis.log.notes import notes_of
from zenvoy.analysis.log.reading import TABLES, read
from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.log.units import UNITS
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import RunMetadata, simulated_s
from zenvoy.bus.topics import CLOCK, ESTIMATE, FLEET_COMMAND, FRAMES, RADAR, TRUTH
from zenvoy.scenarios import Scenario, modes, own_laws

# Types of /v2v/frames in memory. There are at most 10,000 vehicles and 256 outcomes.
_FRAME_TYPES: Final = {
    "cycle": np.uint32,
    "source": np.uint16,
    "destination": np.uint16,
    "sequence": np.uint32,
    "sent_ns": np.int64,
    "arrived_ns": np.int64,
    "latency_ns": np.int64,
    "distance": np.float32,
    "outcome": np.uint8,
}


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Run:
    """A run as arrays, as `zenvoy.analysis.load` returns it and the analysis takes it.

    Fleet tables hold columns (rows, vehicles) by their field names in messages.proto, and `cycle`
    and `time_ns`, (rows,). A column that was not logged is (rows, 0), and a table that was not
    logged is {}. Column v - 1 is vehicle v. Row k is cycle k in every table. Truth has one row more
    than the others, for the run's end. In a run that ended early each table may have a different
    number of rows; all four have the first `cycles` rows.

    In truth and radar `time_ns` is the cycle's start t_k. In estimate and command it is the instant
    of the decision, t_k + v2v_wait, but the estimates `speed`, `ahead_gap`, … are for t_k.

    Studies also make runs without a log, which have no frames.
    """

    path: Path | None
    """The path of its log; None for a run that was not logged."""
    name: str
    """The name of the scenario."""
    seed: int
    """The seed of all that is random in the run."""
    run: dict[str, str]
    """Metadata zenvoy.run: the program and the scenario that made the log."""
    result: dict[str, str]
    """Metadata zenvoy.result: how the run ended; {} where the log is cut before it."""
    scenario: Scenario
    """The scenario with all its defaults."""
    checks: tuple[Check, ...]
    """Checks of what the log says about itself against what is in it."""
    notes: tuple[str, ...]
    """What is wrong with the log or the run, in sentences for people: a cut, an early end, lost
    processes, failed checks."""
    truth: Table
    """The motion of each vehicle as it is; from /fleet/truth."""
    radar: Table
    """The measurements of each vehicle; from /fleet/radar."""
    estimate: Table
    """The estimates behind each decision, and its mode; from /fleet/estimate."""
    command: Table
    """The acceleration that each vehicle asked for; from /fleet/command."""
    clock: Table
    """The messages on the time and pace of the run, (rows,); {} for a run that was not logged."""
    events: list[pb.Event]
    """The events of the run, such as brakings and collisions, in order of time."""
    units: dict[str, dict[str, str]]
    """The unit of each column, by the topic of its table and its name."""
    laws: Mapping[int, LoggedLaw]
    """The laws behind the modes of `estimate`, which also has a column per value that laws log."""
    frame_rows: int
    """The number of rows of `frames`, known without reading them."""

    def __repr__(self) -> str:
        where = self.path or "not logged"
        return f"<Run {self.name}, seed {self.seed}, {self.vehicles} vehicles, {where}>"

    def __getitem__(self, topic: str) -> Table:
        """Return the table of a topic by its name in the log; raises KeyError, also for /events."""
        tables = (self.truth, self.radar, self.estimate, self.command, self.clock)
        if topic == FRAMES.log_name:
            return self.frames
        return dict(zip(TABLES, tables, strict=True))[topic]

    @property
    def log(self) -> Path:
        """The path of its log; raises LogError for a run that was not logged."""
        if self.path is None:
            raise LogError(f"{self.name}, seed {self.seed}: was not logged; its frames need a log")
        return self.path

    @property
    def fingerprint(self) -> str | None:
        """The run's fingerprint; None where it is not logged or does not match the messages."""
        broken = any(check.name == "fingerprint" and check.holds is False for check in self.checks)
        return None if broken else self.result.get("fingerprint")

    @property
    def vehicles(self) -> int:
        """The number of vehicles; vehicles are numbered from 1."""
        return self.scenario.fleet.size

    @property
    def time_s(self) -> NDArray[np.float64]:
        """The time of each row of truth, s; (0,) where there is none."""
        return np.asarray(self.truth.get("time_ns", np.zeros(0)) / 1e9)

    @property
    def cycles(self) -> int:
        """The number of cycles that truth, radar, estimate and command all have."""
        tables = (self.truth, self.radar, self.estimate, self.command)
        return min(len(table.get("cycle", ())) for table in tables)

    @cached_property
    def frames(self) -> Table:
        """The table /v2v/frames: a row per frame and receiver, read from the file on first use.

        Columns are those of messages.proto, (rows,), and `cycle`; sent_ns is the cycle's start.
        Raises LogError.
        """
        messages = read_frames(self.log)
        table: Table = {name: np.empty(self.frame_rows, of) for name, of in _FRAME_TYPES.items()}
        at = 0
        for message in messages:
            end = at + len(message["source"])
            if end > self.frame_rows:  # the run is still being logged
                break
            for name, column in table.items():
                column[at:end] = message[name]
            at = end
        if at != self.frame_rows:
            raise LogError(f"{self.log}: has changed since it was loaded")
        return table

    @cached_property
    def busy_ratio(self) -> NDArray[np.float64]:
        """The share of each cycle in which each vehicle sensed the medium busy, (cycles, vehicles).

        It is (0, vehicles) where frames do not contend for the medium. Raises LogError.
        """
        rows = [np.zeros((0, self.vehicles))]
        if self.scenario.channel.medium.access != "none":
            for message in read_frames(self.log):
                rows.append(message["busy_ratio"].reshape(-1, self.vehicles))
        return np.concatenate(rows).astype(np.float64)


def load(path: str | Path) -> Run:
    """Return the run logged at `path`, up to a cut or gap if there is one; raises LogError.

    What the log says about itself is checked on the way; failed checks are in `notes`.
    """
    path = Path(path)
    reading = read(path)
    facts, tables = reading.facts, reading.tables
    return Run(
        path=path,
        name=facts.run["scenario"],
        seed=facts.scenario.seed,
        run=facts.run,
        result=facts.result,
        scenario=facts.scenario,
        checks=facts.checks,
        notes=notes_of(facts, tables[TRUTH.log_name], reading.events),
        truth=tables[TRUTH.log_name],
        radar=tables[RADAR.log_name],
        estimate=tables[ESTIMATE.log_name],
        command=tables[FLEET_COMMAND.log_name],
        clock=tables[CLOCK.log_name],
        events=reading.events,
        frame_rows=reading.frame_rows,
        laws=reading.laws,
        units=UNITS | {ESTIMATE.log_name: UNITS[ESTIMATE.log_name] | reading.law_units},
    )


def in_memory(
    scenario: Scenario,
    metadata: RunMetadata,
    *,
    end: str,
    tables: Mapping[str, Table],
    events: list[pb.Event],
    fingerprint: str | None = None,
) -> Run:
    """Return a run that was not logged.

    `tables` holds truth, radar, estimate and command by topic, each with `cycle`, `time_ns` and
    the columns that are known. `fingerprint` is that of the log that the run would have, if it is
    known. Such a run has no wall time and no frames.
    """
    truth = tables[TRUTH.log_name]
    described = own_laws(scenario)
    laws = laws_in(described, modes(scenario))
    facts = Facts(
        run=metadata.written(),
        result={
            "end": end,
            "cycles": str(truth["cycle"][-1]),
            "simulated_s": simulated_s(int(truth["time_ns"][-1])),
            **({} if fingerprint is None else {"fingerprint": fingerprint}),
        },
        repair={},
        laws=own_laws_in(laws),
        scenario=scenario,
        counts={},
        whole=True,
        read_cycles=len(truth["cycle"]),
        checks=(),
    )
    return Run(
        path=None,
        name=metadata.scenario,
        seed=scenario.seed,
        run=facts.run,
        result=facts.result,
        scenario=scenario,
        checks=(),
        notes=notes_of(facts, truth, events),
        truth=truth,
        radar=tables[RADAR.log_name],
        estimate=tables[ESTIMATE.log_name],
        command=tables[FLEET_COMMAND.log_name],
        clock={},
        events=events,
        frame_rows=0,
        laws=laws,
        units=UNITS | {ESTIMATE.log_name: UNITS[ESTIMATE.log_name] | units_of(laws)},
    )
