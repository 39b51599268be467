"""The keys of a study, and what is allowed for each."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from zenvoy.values.section import Positive, Section, Seed

SweepEngine = Literal["auto", "arrays", "in-process"]

DescribedSeed = Annotated[Seed, Field(description="a whole number in [0, 2^63)")]
"""A seed as a key of its own, with what a message says is allowed."""

_Names = Annotated[list[str], Field(min_length=1)]


class RunKeys(Section):
    """The keys that sweeps and searches share: the scenario, its settings, seeds and engine."""

    scenario: Annotated[
        str, Field(description="the name of a built-in scenario, or of a file beside the study")
    ]
    description: Annotated[str, Field(description="text")] = ""
    settings: Annotated[
        list[str] | dict[str, Any],
        Field(description="a list of KEY=VALUE, or a mapping of keys of the scenario to values"),
    ] = Field(default_factory=list)
    seeds: Annotated[
        Annotated[int, Field(ge=1)] | Annotated[list[Seed], Field(min_length=1)],
        Field(description="a number of seeds, at least 1, or a list of whole numbers from 0 on"),
    ] = 1
    engine: Annotated[SweepEngine, Field(description="one of auto, arrays, in-process")] = "auto"
    duration_s: Annotated[Positive | None, Field(description="a number in (0, 1e9]")] = None


class StudyKeys(RunKeys):
    """The keys of a study file; axes are checked one by one."""

    axes: Annotated[
        dict[str, Any],
        Field(min_length=1, description="a mapping of keys of the scenario to their values"),
    ]
    measures: Annotated[_Names | None, Field(description="a list of measures")] = None
    series: Annotated[list[str], Field(description="a list of time series")] = Field(
        default_factory=list
    )
