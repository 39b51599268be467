"""How punctual a run in real time was: lateness on the wall clock, from `/realtime`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.arrays import LogError, messages, read_frames
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.load import Run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.clock_bounds import Drift, Offset, mean_drift
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import REALTIME

Floats = NDArray[np.float64]

_PARTS: Final = 10  # drift is measured between the first and the last tenth of a run


class Quantiles(NamedTuple):
    """Quantiles of a lateness, ms of wall time; a negative one is before the deadline."""

    p50: float
    p99: float
    max: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Punctuality:
    """Lateness in ms of wall time, as 1-d arrays; a negative one is before the deadline.

    cycle: each cycle's beginning, after t_k, in order of time. sense: each sense at its vehicle,
    after t_k. decision: each decision, after t_k + v2v_wait. command: each command at the world,
    after it should take effect. delivery: each frame at its receiver, after the drawn instant.
    """

    cycle: Floats
    sense: Floats
    decision: Floats
    command: Floats
    delivery: Floats
    commands_missing: int
    """Commands that had not arrived when their cycle was logged, such as from a lost vehicle."""
    overruns: int
    """Cycles that began more than 1 ms late."""
    clock_error: Floats
    """By how much each command's machine may have been wrong about the world's clock."""
    clock_drift: Drift | None
    """How much the fastest clock of a vehicle gained on the world's; None on one machine."""

    @property
    def commands_late(self) -> int:
        """The number of commands that arrived after they should have taken effect."""
        return int((self.command > 0.0).sum())

    @property
    def drift_ms(self) -> float:
        """The median lateness of cycles in the last tenth of the run minus the first tenth, ms."""
        rows = max(1, len(self.cycle) // _PARTS)
        first, last = np.median(self.cycle[:rows]), np.median(self.cycle[-rows:])
        return float(last - first)


def punctuality(run: Run) -> Punctuality | None:
    """Return the punctuality of a run; None in lock-step, or without a cycle. Raises LogError."""
    rows = _rows(run)
    if not rows:
        return None
    wait_ns = run.scenario.v2v_wait_ns
    start = [row["time_ns"] for row in rows]

    def late(name: str, due: list[Any]) -> Floats:
        """Return the lateness of one column in all rows, without what never happened."""
        pairs = zip(rows, due, strict=True)
        values = [(row[name] - then)[row[name] >= 0] for row, then in pairs]
        return np.asarray(np.concatenate(values) * (1e-6 / run.scenario.speed))

    return Punctuality(
        cycle=np.array([row["began_ns"] - row["time_ns"] for row in rows])
        * (1e-6 / run.scenario.speed),
        sense=late("sensed_ns", start),
        decision=late("decided_ns", [then + wait_ns for then in start]),
        command=late("commanded_ns", [row["deadline_ns"] for row in rows]),
        delivery=late("came_ns", [row["arrived_ns"] for row in rows]),
        commands_missing=sum(int((row["commanded_ns"] < 0).sum()) for row in rows),
        overruns=int(run.clock["overruns"][-1]) if run.clock else 0,
        clock_error=np.concatenate([row["clock_error_ns"][_known(row)] for row in rows]) * 1e-6,
        clock_drift=_fastest(rows, run.scenario.speed),
    )


def _known(row: Table) -> NDArray[np.bool_]:
    return np.asarray(row["clock_error_ns"] >= 0)


def _fastest(rows: list[Table], speed: float) -> Drift | None:
    """Return the drift of the clock that drifts fastest, between the first and the last row."""
    timed = [row for row in rows if row["clock_error_ns"].size and _known(row).all()]
    if len(timed) < 2:
        return None
    first, last = timed[0], timed[-1]
    between_ns = round(int(last["time_ns"] - first["time_ns"]) / speed)
    ends = [
        zip(row["clock_offset_ns"], row["clock_error_ns"], strict=True) for row in (first, last)
    ]
    drifts = [
        mean_drift(Offset(*map(int, one)), Offset(*map(int, other)), between_ns)
        for one, other in zip(*ends, strict=True)
    ]
    return max(drifts, key=lambda one: abs(one.least_ppm + one.most_ppm))


def quantiles(lateness: Floats) -> Quantiles | None:
    """Return the quantiles of a lateness (n,); None where it is empty."""
    if not lateness.size:
        return None
    return Quantiles(*(float(q) for q in np.percentile(lateness, (50, 99, 100))))


def missed_decisions(run: Run) -> tuple[int, int]:
    """Return how many frames missed the decision they were due for, and how many were due.

    A frame is due if its drawn latency is short enough for the first decision after it was sent.
    Raises LogError.
    """
    deadline_ns = run.scenario.v2v_wait_ns or run.scenario.period_ns
    missed = met = 0
    for frames in read_frames(run.log):
        due = (frames["latency_ns"] >= 0) & (frames["latency_ns"] <= deadline_ns)
        missed += int((due & (frames["outcome"] == pb.OUTCOME_LATE)).sum())
        met += int((due & (frames["outcome"] == pb.OUTCOME_DELIVERED)).sum())
    return missed, missed + met


def _rows(run: Run) -> list[Table]:
    codec = PackedCodec(pb.RealTime.DESCRIPTOR)
    rows = []
    for topic, payload in messages(run.log, [REALTIME.log_name]):
        try:
            rows.append(codec.decode(payload))
        except ValueError as error:
            raise LogError(f"{run.log}: {topic}: {error}") from error
    return rows
