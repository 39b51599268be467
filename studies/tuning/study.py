"""A study for `zenvoy tune`: its parameters, its objective and its constraints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from zenvoy.studies.sweeps.axes import Listed
from zenvoy.studies.sweeps.plan import Plan, Point, plan_of
from zenvoy.studies.sweeps.study_file import StudyFile
from zenvoy.studies.tuning.figures import FIGURES, is_theoretical
from zenvoy.studies.tuning.keys import Sampler
from zenvoy.studies.tuning.parameters import Parameter

Direction = Literal["minimize", "maximize"]
Bound = Literal["max", "min"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Constraint:
    """A limit that a figure must hold, with every seed."""

    figure: str
    bound: Bound
    limit: float

    @property
    def name(self) -> str:
        """The name in the table: "collisions.max", or just the figure if it is theoretical."""
        return self.figure if is_theoretical(self.figure) else f"{self.figure}.{self.bound}"

    @property
    def unit(self) -> str:
        """The unit of the figure."""
        return FIGURES[self.figure].unit

    def worst(self, values: Sequence[float]) -> float:
        """Return the worst value of all seeds: nearest to the limit, or farthest beyond it."""
        return max(values) if self.bound == "max" else min(values)

    def excess(self, values: Sequence[float]) -> float:
        """Return by how much the worst value is beyond the limit; below 0 if it holds."""
        beyond = self.worst(values) - self.limit
        return beyond if self.bound == "max" else -beyond

    def broken(self, values: Sequence[float]) -> str:
        """Return a line that says that the values do not satisfy the constraint."""
        side = "above" if self.bound == "max" else "below"
        return f"{self.figure} {self.worst(values):.6g} is {side} {self.limit:g}"

    def __str__(self) -> str:
        return f"{self.figure} {'≤' if self.bound == 'max' else '≥'} {self.limit:g}"


@dataclass(frozen=True, kw_only=True)
class TuneStudy:
    """A study, checked as far as it can be without its scenario."""

    runs: StudyFile
    """Scenario, settings, seeds and engine of its runs, without the parameters."""
    parameters: Mapping[str, Parameter]
    direction: Direction
    figure: str
    constraints: tuple[Constraint, ...]
    trials: int
    sampler: Sampler
    allow_code: bool
    """Whether laws may lie anywhere, not only beside the scenario."""

    @property
    def name(self) -> str:
        """The name of the study."""
        return self.runs.name

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of each trial."""
        return self.runs.each_seed

    @property
    def figures(self) -> tuple[str, ...]:
        """All figures of a trial, each once: the objective, then those of constraints."""
        named = (self.figure, *(constraint.figure for constraint in self.constraints))
        return tuple(dict.fromkeys(named))

    @property
    def measured(self) -> tuple[str, ...]:
        """The figures that need runs."""
        return self.runs.measures or ()

    def plan_at(self, point: Point) -> Plan:
        """Return the runs of a trial, as of a sweep with a single cell; raises BadStudyError."""
        axes = {key: Listed(values=[value]) for key, value in point.items()}
        return plan_of(replace(self.runs, axes=axes), allow_code=self.allow_code)

    @property
    def identity(self) -> dict[str, Any]:
        """The values that stay the same when a study gets more trials."""
        return {
            "settings": sorted(self.runs.settings),
            "duration_s": self.runs.duration_s,
            "seeds": list(self.seeds),
            "parameters": {key: one.model_dump() for key, one in self.parameters.items()},
            self.direction: self.figure,
            "constraints": [str(constraint) for constraint in self.constraints],
            "sampler": self.sampler.model_dump(),
        }
