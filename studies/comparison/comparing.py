"""Compares laws: a sweep of one scenario over laws, with the same seeds for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.scenarios import COMMAND_LINE, Place, Scenario, Spelling
from zenvoy.scenarios.reading.origin import located
from zenvoy.studies.comparison.compared import Comparison
from zenvoy.studies.comparison.laws import Base, ComparedLaw, laws_of
from zenvoy.studies.comparison.page import write_results
from zenvoy.studies.comparison.speeds import SERIES_SHOWN
from zenvoy.studies.sweeps.checking import unknown
from zenvoy.studies.sweeps.errors import BadStudyError, bad_study
from zenvoy.studies.sweeps.page import README
from zenvoy.studies.sweeps.study_file import StudyFile, read_study
from zenvoy.studies.sweeps.sweep import OnLine, make_runs

MEASURED: Final = (
    "smallest_gap_m",
    "gap_error_rms_m",
    "tail_speed_swing_mps",
    "speed_swing_ratio",
    "acceleration_rms_mps2",
    "jerk_rms_mps3",
    "collisions",
    "fallbacks",
)
"""The measures of a comparison that names none, if gaps are from front to front."""

SEEDS: Final = 30

_AXIS: Final = "law"
_ARGUMENTS: Final = {  # by the keys of a study
    "axes": "laws",
    _AXIS: "laws",
    "settings": "settings",
    "seeds": "seeds",
    "measures": "measures",
    "duration_s": "duration_s",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparing:
    """A comparison to make: laws, given as texts, in a scenario, over seeds."""

    scenario: str
    laws: Sequence[str]
    labels: Sequence[str] = ()
    seeds: int | Sequence[int] = SEEDS
    measures: Sequence[str] = ()
    settings: Sequence[str] = ()
    duration_s: float | None = None
    allow_code: bool = False
    spelling: Spelling = COMMAND_LINE
    """How errors spell these arguments."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """The outcome of a comparison, its folder, and the files that it wrote."""

    comparison: Comparison
    folder: Path
    files: tuple[Path, ...]

    @property
    def readme(self) -> Path:
        """The page that says what was run, and what failed."""
        return self.folder / README


def run_comparison(
    asked: Comparing,
    *,
    out: Path | None,
    jobs: int | None,
    on_line: OnLine,
    command: str,
    dask: str | None = None,
) -> Compared:
    """Make the missing runs of a comparison, then write its tables and pictures.

    `out` is runs/<name of the scenario>-laws by default. For `jobs`, `on_line` and `dask`, and for
    what is raised, see `run_sweep`.
    """
    base = Base(
        scenario=asked.scenario,
        settings=tuple(asked.settings),
        duration_s=asked.duration_s,
        allow_code=asked.allow_code,
        spelling=asked.spelling,
    )
    _require_measures(asked.measures, asked.spelling)
    _require_no_law(asked.settings, asked.spelling)
    laws = laws_of(base, asked.laws, asked.labels)
    scenario = base.load().scenario
    notes = tuple(_notes(scenario, laws, asked.spelling))
    for note in notes:
        on_line(note)
    made = make_runs(
        _study(replace(asked, measures=asked.measures or measured(scenario)), laws),
        out=out,
        jobs=jobs,
        on_line=on_line,
        allow_code=asked.allow_code,
        dask=dask,
    )
    compared = Comparison(laws=laws, results=made.results, notes=notes)
    files = write_results(compared, made.store, command)
    return Compared(comparison=compared, folder=made.store.folder, files=tuple(files))


def measured(scenario: Scenario) -> tuple[str, ...]:
    """Return the measures of a comparison that names none, with gaps as the scenario has them."""
    if scenario.fleet.reported_gaps == "front-to-front":
        return MEASURED
    return ("smallest_bumper_gap_m", *MEASURED[1:])


def _require_measures(names: Sequence[str], spelling: Spelling) -> None:
    for name in names:
        spelled = spelling.option("measures", name)
        if name not in MEASURES:
            raise bad_study("", unknown(name, list(MEASURES)), Place(source=spelled))
        if names.count(name) > 1:
            raise bad_study("", f"{spelled}: is given twice; allowed: once")


def _require_no_law(settings: Sequence[str], spelling: Spelling) -> None:
    for setting in settings:
        key = setting.partition("=")[0].strip()
        if key in ("control.model", "control.parameters"):
            text = f"is what a comparison varies; allowed: {spelling.argument('laws')}"
            raise bad_study(key, text, Place(source=spelling.setting(setting)))


def _study(asked: Comparing, laws: Sequence[ComparedLaw]) -> StudyFile:
    """Return the comparison as a study for a sweep, whose problems name the options."""
    keys: dict[str, Any] = {
        "scenario": asked.scenario,
        "settings": list(asked.settings),
        "axes": {_AXIS: {"variants": {law.label: dict(law.settings) for law in laws}}},
        "seeds": asked.seeds if isinstance(asked.seeds, int) else list(asked.seeds),
        "measures": list(asked.measures),
        "series": list(SERIES_SHOWN),
    }
    if asked.duration_s is not None:
        keys["duration_s"] = asked.duration_s
    name = f"{located(asked.scenario).name.rpartition('/')[2]}-laws"
    try:
        study = read_study(keys, asked.spelling)
    except BadStudyError as error:
        raise BadStudyError(
            replace(one, place=_place(one.key.partition(".")[0], one.place, asked.spelling))
            for one in error.problems
        ) from None
    places = {
        key: _place(key, place, asked.spelling) or place for key, place in study.places.items()
    }
    return replace(study, name=name, places=places)


def _place(key: str, otherwise: Place | None, spelling: Spelling) -> Place | None:
    """Return the argument that stands for a key of a study; `otherwise` if there is none."""
    return Place(source=spelling.argument(_ARGUMENTS[key])) if key in _ARGUMENTS else otherwise


def _notes(scenario: Scenario, laws: Sequence[ComparedLaw], spelling: Spelling) -> list[str]:
    """Return what a reader of the comparison must know about its runs, in sentences."""
    found = [
        f"{law.label} runs in process, not on arrays: {'; '.join(law.not_arrays)}"
        for law in laws
        if law.not_arrays
    ]
    switched = [switch for switch in scenario.control.schedule if switch.model is not None]
    if switched:
        remedy = spelling.setting("control.schedule=[]")
        found.append(
            f"control.schedule changes laws from {switched[0].at_s:g} s on; the laws compared here"
            f" drive the vehicles concerned only before that ({remedy} removes it)"
        )
    grouped = [group.name for group in scenario.fleet.groups if group.model is not None]
    if grouped:
        found.append(f"groups keep laws of their own: {', '.join(grouped)}")
    return found
