"""A user's own study, read from a file or a mapping."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Any, NamedTuple

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.series import SERIES
from zenvoy.scenarios import COMMAND_LINE, Place, Problem, ScenarioError, Spelling
from zenvoy.scenarios.reading.origin import from_here
from zenvoy.scenarios.reading.source import parse
from zenvoy.scenarios.reading.tree import Node
from zenvoy.studies.sweeps.axes import Axis
from zenvoy.studies.sweeps.axes_reading import axes_of, varied
from zenvoy.studies.sweeps.checking import checked, entries, repeated, wrong_names
from zenvoy.studies.sweeps.errors import BadStudyError, bad_study
from zenvoy.studies.sweeps.settings import as_settings, settings_problems
from zenvoy.studies.sweeps.study_keys import RunKeys, StudyKeys, SweepEngine
from zenvoy.values.wording import shown


@dataclass(frozen=True, kw_only=True)
class StudyFile:
    """A study, checked as far as it can be without its scenario."""

    name: str
    text: str
    scenario: str
    """The name of a built-in scenario, or the path of a file."""
    description: str
    settings: tuple[str, ...]
    axes: Mapping[str, Axis]
    seeds: tuple[int, ...] | int
    """The seeds, or their number: 1, 2, and so on."""
    measures: tuple[str, ...] | None
    """None stands for every figure that the runs have and that needs no log."""
    series: tuple[str, ...]
    engine: SweepEngine
    duration_s: float | None
    places: Mapping[str, Place]
    """Where each axis, and the keys `axes`, `settings`, `seeds` and `scenario`, are written."""
    spelling: Spelling
    """How errors spell the arguments of the study."""

    @property
    def needs_log(self) -> bool:
        """Whether the study wants a measure that only a run with a log has."""
        return any(MEASURES[name].needs_log for name in self.measures or ())

    @property
    def seed_count(self) -> int:
        """The number of seeds."""
        return self.seeds if isinstance(self.seeds, int) else len(self.seeds)

    @property
    def each_seed(self) -> tuple[int, ...]:
        """Every seed; a number of seeds stands for 1, 2, and so on."""
        return self.seeds if isinstance(self.seeds, tuple) else tuple(range(1, self.seeds + 1))


class Written(NamedTuple):
    """A study as written: its tree, name and text, and the folder of its file."""

    root: Node
    name: str
    text: str
    folder: Path | None


def read_study(
    study: str | PathLike[str] | Mapping[str, Any], spelling: Spelling = COMMAND_LINE
) -> StudyFile:
    """Return the study in a file, or that of a mapping with the same keys; raises BadStudyError."""
    return _study(written(study, "sweep"), spelling)


def written(study: str | PathLike[str] | Mapping[str, Any], name: str) -> Written:
    """Return a study as written in a file, or in a mapping, which gets the name.

    Raises BadStudyError if it cannot be read, or is not a mapping.
    """
    if isinstance(study, Mapping):
        place = Place(source="study")
        text = json.dumps(study, indent=2, default=_plain, ensure_ascii=False)
        root, _ = parse(text, lambda _: place)
        return _mapping(Written(root or Node({}, place), name, text, None))
    path = Path(fspath(study))
    try:
        text = from_here(path).text()
        root, problems = parse(
            text, lambda line: Place(source=str(path), line=line), top_level=True
        )
    except ScenarioError as error:
        raise BadStudyError(error.problems) from None
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise bad_study("", f"{shown(str(path))} cannot be read: {why}") from None
    if problems:
        raise BadStudyError(problems)
    root = root or Node({}, Place(source=str(path)))
    return _mapping(Written(root, path.stem, text, path.parent))


def _mapping(found: Written) -> Written:
    if not isinstance(found.root.value, dict):
        raise bad_study("", f"{shown(found.root.plain())} is not a mapping", found.root.place)
    return found


def _plain(value: object) -> object:
    """Return numpy's arrays and numbers, and paths, as values that JSON allows."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, PathLike):
        return fspath(value)
    raise bad_study("", f"a value of type {type(value).__name__} is not allowed")


def _study(found: Written, spelling: Spelling) -> StudyFile:
    """Return the study that a tree describes; raises BadStudyError with all its problems."""
    root = found.root
    keys, problems = checked(StudyKeys, root, ())
    axes, in_axes = axes_of(root.find(("axes",)))
    problems = [*problems, *in_axes]
    if keys is not None:
        problems += wrong_names("measures", keys.measures or (), MEASURES, root)
        problems += wrong_names("series", keys.series, SERIES, root)
        problems += run_problems(keys, varied(axes), "an axis", root)
    if keys is None or problems:
        raise BadStudyError(problems)
    return study_file(
        found,
        keys,
        "axes",
        axes=axes,
        measures=None if keys.measures is None else tuple(keys.measures),
        series=tuple(keys.series),
        spelling=spelling,
    )


def run_problems(keys: RunKeys, varied: Iterable[str], what: str, root: Node) -> Iterator[Problem]:
    """Yield the problems of the keys that sweeps and searches share.

    `varied` are the settings that the study varies, as `what`: "an axis".
    """
    yield from repeated("seeds", keys.seeds if isinstance(keys.seeds, list) else (), root)
    yield from settings_problems(keys.settings, varied, what, root)


def study_file(
    found: Written,
    keys: RunKeys,
    varied: str,
    *,
    axes: Mapping[str, Axis],
    measures: tuple[str, ...] | None,
    series: tuple[str, ...] = (),
    spelling: Spelling,
) -> StudyFile:
    """Return the study of checked keys. `varied` is the key of the settings that it varies."""
    nodes = entries(found.root) | entries(found.root.find((varied,)))
    return StudyFile(
        name=found.name,
        text=found.text,
        scenario=_beside(found.folder, keys.scenario),
        description=keys.description,
        settings=tuple(as_settings(keys.settings)),
        axes=axes,
        seeds=keys.seeds if isinstance(keys.seeds, int) else tuple(keys.seeds),
        measures=measures,
        series=series,
        engine=keys.engine,
        duration_s=keys.duration_s,
        places={key: node.place for key, node in nodes.items()},
        spelling=spelling,
    )


def _beside(folder: Path | None, scenario: str) -> str:
    """Return the path of a scenario beside the study; else the name as it is."""
    if folder is not None and (folder / scenario).is_file():
        return str(folder / scenario)
    return scenario
