"""The keys of a study for `zenvoy tune`, and what is allowed for each."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from zenvoy.studies.sweeps.axes import Number
from zenvoy.studies.sweeps.study_keys import DescribedSeed, RunKeys
from zenvoy.values.section import Section

MOST_TRIALS = 10_000

_Limit = Annotated[Number | None, Field(description="a number in [-1e9, 1e9]")]


class TuneKeys(RunKeys):
    """The keys of a study; parameters, constraints and the sampler are checked one by one."""

    parameters: Annotated[
        dict[str, Any],
        Field(min_length=1, description="one key of the scenario or more, each with its range"),
    ]
    minimize: Annotated[str | None, Field(description="a measure")] = None
    maximize: Annotated[str | None, Field(description="a measure")] = None
    constraints: Annotated[
        dict[str, Any], Field(description="a mapping of measures to max or min")
    ] = Field(default_factory=dict)
    trials: Annotated[
        int, Field(ge=1, le=MOST_TRIALS, description=f"a whole number in [1, {MOST_TRIALS}]")
    ] = 50
    sampler: Annotated[dict[str, Any], Field(description="a mapping of kind, seed and startup")] = (
        Field(default_factory=dict)
    )


class Limits(Section):
    """The limits of a constraint."""

    max: _Limit = None
    min: _Limit = None


class Sampler(Section):
    """The sampler, which proposes the trials."""

    kind: Annotated[Literal["tpe", "random"], Field(description="one of tpe, random")] = "tpe"
    seed: DescribedSeed = 1
    startup: Annotated[
        int, Field(ge=1, le=MOST_TRIALS, description=f"a whole number in [1, {MOST_TRIALS}]")
    ] = 10
