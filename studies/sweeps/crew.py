"""The crew that makes the runs of a study: processes on this machine, or a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from zenvoy.studies.sweeps.plan import Plan
from zenvoy.studies.sweeps.running import keep_runs
from zenvoy.studies.sweeps.store import Store
from zenvoy.studies.sweeps.tasks import Task
from zenvoy.studies.sweeps.workers import Done, each_done


class Crew(Protocol):
    """Makes the runs of tasks, several tasks at a time."""

    @property
    def at_a_time(self) -> int:
        """The number of tasks that it makes at a time."""

    def each_done(self, tasks: Sequence[Task], plan: Plan, store: Store) -> Iterator[Done[Task]]:
        """Make the runs of each task, and keep them in the store; yield each task as it ends.

        A task that fails does not stop the others.
        """


@dataclass(frozen=True, slots=True)
class Cores:
    """Processes on this machine; see Crew."""

    at_a_time: int

    def each_done(self, tasks: Sequence[Task], plan: Plan, store: Store) -> Iterator[Done[Task]]:
        """See Crew."""
        return each_done(tasks, partial(_make, plan, store), self.at_a_time)


def _make(plan: Plan, store: Store, task: Task) -> None:
    cells = [plan.cell(task.cell, seed) for seed in task.seeds]
    keep_runs(cells, task.keys, task.cell.engine, plan.study.series, store)
