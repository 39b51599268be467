"""A finished trial: its values, its figures with every seed, and whether the limits hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from zenvoy.studies.sweeps.plan import Point
from zenvoy.studies.sweeps.settings import setting_of
from zenvoy.studies.tuning.study import Constraint, TuneStudy


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A point of the search, and its results."""

    number: int
    """Number of the trial, from 1."""
    point: Point
    figures: Mapping[str, tuple[float, ...]]
    """Values by figure: one of theory, or one for each seed; none if the trial was not run."""
    failure: str | None = None
    """Why the trial has no figures although it was run."""

    def objective(self, study: TuneStudy) -> float | None:
        """Return the objective, a mean over the seeds; None if it is not known."""
        values = self.figures.get(study.figure)
        return None if self.failure or not values else sum(values) / len(values)

    def broken(self, study: TuneStudy) -> list[Constraint]:
        """Return the constraints that are known not to hold."""
        known = [one for one in study.constraints if self.figures.get(one.figure)]
        return [one for one in known if one.excess(self.figures[one.figure]) > 0.0]

    def feasible(self, study: TuneStudy) -> bool:
        """Return whether it has all its figures, and satisfies every constraint."""
        return self.objective(study) is not None and not self.broken(study)

    @property
    def as_settings(self) -> tuple[str, ...]:
        """Its values as settings, KEY=VALUE."""
        return tuple(setting_of(key, value) for key, value in self.point.items())

    @property
    def settings(self) -> str:
        """Its values on one line."""
        return " ".join(self.as_settings)

    def told(self, study: TuneStudy) -> str:
        """Return the results on one line."""
        if self.failure:
            return f"failed: {self.failure}"
        objective = self.objective(study)
        broken = ", ".join(one.broken(self.figures[one.figure]) for one in self.broken(study))
        if objective is None:
            return f"ruled out: {broken}"
        found = f"{study.figure} {objective:.6g}"
        return f"{found}, but {broken}" if broken else found


def best_of(study: TuneStudy, trials: Sequence[Trial]) -> Trial | None:
    """Return the feasible trial with the best objective, the first of equals; None if none is."""
    return next(iter(ranked(study, trials)), None)


def ranked(study: TuneStudy, trials: Sequence[Trial]) -> list[Trial]:
    """Return the feasible trials, the best first."""
    sign = 1.0 if study.direction == "minimize" else -1.0
    found = [trial for trial in trials if trial.feasible(study)]
    return sorted(found, key=lambda trial: (sign * (trial.objective(study) or 0.0), trial.number))
