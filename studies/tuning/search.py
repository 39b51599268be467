"""Proposes the next trial of a search from the earlier trials alone.

Optuna's samplers have a state. Here each trial gets a new sampler, with a seed derived from the
study's seed and the number of the trial. So a resumed search proposes what it would have proposed
without the stop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import optuna
from optuna.distributions import (
    BaseDistribution,
    CategoricalDistribution,
    FloatDistribution,
    IntDistribution,
)
from optuna.samplers import BaseSampler, RandomSampler, TPESampler
from optuna.trial import FrozenTrial, TrialState, create_trial

from zenvoy.keyed_random.draws import Purpose, uniforms
from zenvoy.studies.sweeps.plan import Point
from zenvoy.studies.tuning.parameters import Choices, Parameter, Span
from zenvoy.studies.tuning.study import TuneStudy
from zenvoy.studies.tuning.trial import Trial

_FAILED: Final = "failed"
_MOST: Final = 1e6  # of an excess, which may be infinite


def proposal(study: TuneStudy, trials: Sequence[Trial]) -> Point:
    """Return the values to try after these trials, which are in order of number."""
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    search = optuna.create_study(direction=study.direction, sampler=_sampler(study, len(trials)))
    for trial in trials:
        search.add_trial(as_frozen(study, trial))
    asked = search.ask(distributions(study)).params
    return {key: one.value_of(asked[key]) for key, one in study.parameters.items()}


def distributions(study: TuneStudy) -> dict[str, BaseDistribution]:
    """Return the ranges of all parameters in Optuna's form."""
    return {key: _distribution(parameter) for key, parameter in study.parameters.items()}


def as_frozen(study: TuneStudy, trial: Trial) -> FrozenTrial:
    """Return a trial in Optuna's form; one without an objective counts as pruned.

    The excess over a limit is relative to the limit, so that different units are comparable.
    """
    objective = trial.objective(study)
    excess = {
        f"{one.figure}.{one.bound}": _scaled(one.excess(trial.figures[one.figure]), one.limit)
        for one in study.constraints
        if trial.figures.get(one.figure)
    }
    return create_trial(
        state=TrialState.PRUNED if objective is None else TrialState.COMPLETE,
        value=objective,
        params={key: one.proposed_as(trial.point[key]) for key, one in study.parameters.items()},
        distributions=distributions(study),
        constraints=excess | ({_FAILED: 1.0} if trial.failure else {}),
    )


def _sampler(study: TuneStudy, before: int) -> BaseSampler:
    draw, _ = uniforms(study.sampler.seed, Purpose.SEARCH, 0, 0, before)
    seed = int(draw * 2**32)
    if study.sampler.kind == "random":
        return RandomSampler(seed=seed)
    return TPESampler(seed=seed, n_startup_trials=study.sampler.startup)


def _distribution(parameter: Parameter) -> BaseDistribution:
    if isinstance(parameter, Choices):
        return CategoricalDistribution(parameter.labels)
    assert isinstance(parameter, Span)
    if parameter.whole:
        step = int(parameter.step or 1)
        return IntDistribution(int(parameter.low), int(parameter.high), parameter.log, step)
    low, high = float(parameter.low), float(parameter.high)
    return FloatDistribution(low, high, parameter.log, parameter.step)


def _scaled(excess: float, limit: float) -> float:
    return math.copysign(min(abs(excess) / (abs(limit) or 1.0), _MOST), excess)
