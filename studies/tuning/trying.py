"""Makes a trial: theory first, and runs only if theory allows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from zenvoy.analysis.measures.figures import figures
from zenvoy.scenarios import Scenario, ScenarioError
from zenvoy.studies.sweeps.plan import Plan, Point
from zenvoy.studies.sweeps.store import Store
from zenvoy.studies.sweeps.sweep import make_missing
from zenvoy.studies.tuning.figures import in_theory, is_theoretical
from zenvoy.studies.tuning.study import TuneStudy
from zenvoy.studies.tuning.trial import Trial

_COLLISIONS: Final = "collisions"

Found = dict[str, tuple[float, ...]]


def tried(study: TuneStudy, number: int, point: Point, store: Store, jobs: int) -> Trial:
    """Make and return the trial of a point; the store keeps its runs. Raises OSError.

    A trial that breaks a constraint in theory is not run. The `failure` of a trial says why it
    failed.
    """
    try:
        plan = study.plan_at(point)
        scenario = plan.cell(plan.cells[0], plan.seeds[0]).load().scenario
    except ScenarioError as error:
        why = "; ".join(str(error).splitlines())
        return Trial(number=number, point=point, figures={}, failure=why)
    found, failure = _in_theory(study, scenario)
    trial = Trial(number=number, point=point, figures=found, failure=failure)
    if failure is not None or trial.broken(study) or not study.measured:
        return trial
    measured, failure = _measured(study, plan, scenario.cycles, store, jobs)
    return Trial(number=number, point=point, figures=found | measured, failure=failure)


def _in_theory(study: TuneStudy, scenario: Scenario) -> tuple[Found, str | None]:
    found: Found = {}
    for name in filter(is_theoretical, study.figures):
        value = in_theory(name, scenario)
        if isinstance(value, str):
            return found, value
        found[name] = (value,)
    return found, None


def _measured(
    study: TuneStudy, plan: Plan, cycles: int, store: Store, jobs: int
) -> tuple[Found, str | None]:
    """Return the figures of the runs, each of which has this many cycles unless it is stopped."""
    (cell,) = plan.cells
    failures = make_missing(plan, store, jobs, lambda _: None)
    of_seeds: list[Mapping[str, float | None]] = []
    stopped: str | None = None
    for seed, key in zip(plan.seeds, cell.keys, strict=True):
        if key in failures:
            return {}, f"seed {seed}: {failures[key]}"
        values = figures(store.summary(key) or {})
        if stopped is None and (values["cycles"] or 0) < cycles:
            stopped = f"seed {seed}: stopped at {values['simulated_s']:g} s by a collision"
        of_seeds.append(values)
    if stopped is not None:
        return _stopped(study, of_seeds, stopped)
    found: Found = {}
    for name in study.measured:
        if (known := _known(name, of_seeds)) is None:
            return {}, f"{name} does not apply to this run"
        found[name] = known
    return found, None


def _stopped(
    study: TuneStudy, of_seeds: Sequence[Mapping[str, float | None]], why: str
) -> tuple[Found, str | None]:
    """Return what is known about runs that a collision stopped: the number of collisions.

    They fail unless a constraint rules them out. Their other measures cover less time than those of
    whole runs.
    """
    count = _known(_COLLISIONS, of_seeds)
    limits = [one for one in study.constraints if one.figure == _COLLISIONS]
    if count is not None and any(one.excess(count) > 0.0 for one in limits):
        return {_COLLISIONS: count}, None
    return {}, why


def _known(name: str, of_seeds: Sequence[Mapping[str, float | None]]) -> tuple[float, ...] | None:
    """Return a figure with every seed; None if it does not apply to one of them."""
    known = tuple(value for values in of_seeds if (value := values[name]) is not None)
    return known if len(known) == len(of_seeds) else None
