"""The missing runs of a study, in portions for one process each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from zenvoy.studies.sweeps.plan import Plan, PlannedCell
from zenvoy.studies.sweeps.store import Store

_MOST_SEEDS: Final = 100  # in a batch: more are hardly faster, and a stop would lose more runs


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Runs of a cell that one process makes."""

    cell: PlannedCell
    seeds: tuple[int, ...]
    keys: tuple[str, ...]

    @property
    def key(self) -> str:
        """The key of its only or first run."""
        return self.keys[0]

    def split(self) -> list[Task]:
        """Return a task for each of its runs."""
        pairs = zip(self.seeds, self.keys, strict=True)
        return [Task(cell=self.cell, seeds=(seed,), keys=(key,)) for seed, key in pairs]

    def __str__(self) -> str:
        seeds = " ".join(map(str, self.seeds[:3])) + (" …" if len(self.seeds) > 3 else "")
        return f"{self.cell}, seed{'s' if len(self.seeds) > 1 else ''} {seeds}"


def missing_tasks(plan: Plan, store: Store, at_a_time: int) -> list[Task]:
    """Return tasks for the missing runs; equal combinations are run once.

    On arrays a task has many seeds of a cell. On other engines it has one run, and the tasks go
    seed by seed, so that a stopped sweep has all cells of some seeds.
    """
    taken: set[str] = set()
    missing: list[Task] = []
    for cell in plan.cells:
        pairs = zip(plan.seeds, cell.keys, strict=True)
        left = [(s, k) for s, k in pairs if k not in taken and not store.has(k, plan.study)]
        taken.update(cell.keys)
        if left:
            seeds, keys = zip(*left, strict=True)
            missing.append(Task(cell=cell, seeds=seeds, keys=keys))
    together = [task for task in missing if task.cell.engine == "arrays"]
    alone = [one for task in missing if task.cell.engine != "arrays" for one in task.split()]
    alone.sort(key=lambda task: plan.seeds.index(task.seeds[0]))
    parts = max(1, -(-at_a_time // max(1, len(together))))  # few cells: several tasks for each
    return [part for task in together for part in _parts(task, parts)] + alone


def _parts(task: Task, parts: int) -> Iterator[Task]:
    size = min(_MOST_SEEDS, -(-len(task.seeds) // parts))
    for start in range(0, len(task.seeds), size):
        some = slice(start, start + size)
        yield Task(cell=task.cell, seeds=task.seeds[some], keys=task.keys[some])
