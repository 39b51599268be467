"""A parcel for a worker: everything that its runs need, in bytes, so that no disk is shared."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, replace

from zenvoy.fleet.engine import Engine
from zenvoy.laws.by_name import ESTIMATORS, LAWS
from zenvoy.laws.carried import Carried, carried
from zenvoy.scenarios import Loaded, modes
from zenvoy.studies.sweeps.plan import Plan
from zenvoy.studies.sweeps.running import keep_loaded
from zenvoy.studies.sweeps.store import Store
from zenvoy.studies.sweeps.tasks import Task


@dataclass(frozen=True, slots=True, kw_only=True)
class Parcel:
    """The runs of a task: a scenario with all its values, its seeds, and its own laws."""

    loaded: Loaded
    seeds: tuple[int, ...]
    keys: tuple[str, ...]
    engine: Engine
    series: tuple[str, ...]
    laws: tuple[Carried, ...]

    def make(self, store: Store) -> None:
        """Make the runs, and keep them in the store.

        Raises UnknownLawError if a law cannot be loaded here, or what `keep_loaded` raises.
        """
        for law in self.laws:
            law.load()
        scenario = self.loaded.scenario
        runs = [
            replace(self.loaded, scenario=scenario.model_copy(update={"seed": seed}))
            for seed in self.seeds
        ]
        keep_loaded(runs, self.keys, self.engine, self.series, store)

    def packed(self) -> bytes:
        """Return the parcel as bytes, for the same version of Zenvoy."""
        return pickle.dumps(self)


def parcel_in(packed: bytes) -> Parcel:
    """Return the parcel in packed bytes."""
    parcel: Parcel = pickle.loads(packed)
    return parcel


def parcel_of(plan: Plan, task: Task) -> Parcel:
    """Return a task for a worker; raises ScenarioError if its scenario is no longer valid."""
    loaded = plan.cell(task.cell, task.seeds[0]).load()
    named = [carried(model, LAWS) for model in modes(loaded.scenario)]
    named.append(carried(loaded.scenario.estimator.kind, ESTIMATORS))
    return Parcel(
        loaded=loaded,
        seeds=task.seeds,
        keys=task.keys,
        engine=task.cell.engine,
        series=plan.study.series,
        laws=tuple(law for law in named if law is not None),
    )
