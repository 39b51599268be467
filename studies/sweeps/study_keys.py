"""The keys of a study, and what is allowed for each."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from zenvoy.values.section import Positive, Section

SweepEngine = Literal["auto", "arrays", "in-process"]

_Seed = Annotated[int, Field(ge=0, lt=2**63)]
_Names = Annotated[list[str], Field(min_length=1)]


# What the keys that sweeps and searches share may hold.
ScenarioKey = Annotated[
    str, Field(description="the name of a built-in scenario, or of a file beside the study")
]
DescriptionKey = Annotated[str, Field(description="text")]
SettingsKey = Annotated[
    list[str] | dict[str, Any],
    Field(description="a list of KEY=VALUE, or a mapping of keys of the scenario to values"),
]
SeedsKey = Annotated[
    Annotated[int, Field(ge=1)] | Annotated[list[_Seed], Field(min_length=1)],
    Field(description="a number of seeds, at least 1, or a list of whole numbers from 0 on"),
]
EngineKey = Annotated[SweepEngine, Field(description="one of auto, arrays, in-process")]
DurationKey = Annotated[Positive | None, Field(description="a number in (0, 1e9]")]


class StudyKeys(Section):
    """The keys of a study file; axes are checked one by one."""

    scenario: ScenarioKey
    description: DescriptionKey = ""
    settings: SettingsKey = Field(default_factory=list)
    axes: Annotated[
        dict[str, Any],
        Field(min_length=1, description="a mapping of keys of the scenario to their values"),
    ]
    seeds: SeedsKey = 1
    measures: Annotated[_Names | None, Field(description="a list of measures")] = None
    series: Annotated[list[str], Field(description="a list of time series")] = Field(
        default_factory=list
    )
    engine: EngineKey = "auto"
    duration_s: DurationKey = None
