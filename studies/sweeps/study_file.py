"""A study of the user's own: its keys, and how it is read from a file or a mapping."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.series import SERIES
from zenvoy.scenarios import Place, Problem, ScenarioError
from zenvoy.scenarios.reading.origin import from_here
from zenvoy.scenarios.reading.source import parse
from zenvoy.scenarios.reading.tree import Node
from zenvoy.studies.sweeps.axes import DISTRIBUTIONS, Axis, Listed, Range
from zenvoy.studies.sweeps.checking import checked, unknown
from zenvoy.studies.sweeps.errors import BadStudyError, bad_study
from zenvoy.values.section import Positive, Section
from zenvoy.values.wording import shown

SweepEngine = Literal["auto", "arrays", "in-process"]

_OWN_KEYS: Final = {"seed": "seeds", "extends": "scenario"}
_Seed = Annotated[int, Field(ge=0, lt=2**63)]
_Names = Annotated[list[str], Field(min_length=1)]


class StudyKeys(Section):
    """The keys of a study file; axes are checked one by one."""

    scenario: Annotated[
        str, Field(description="the name of a built-in scenario, or of a file beside the study")
    ]
    description: Annotated[str, Field(description="text")] = ""
    settings: Annotated[
        list[str] | dict[str, Any],
        Field(description="a list of KEY=VALUE, or a mapping of keys of the scenario to values"),
    ] = Field(default_factory=list)
    axes: Annotated[
        dict[str, Any],
        Field(min_length=1, description="a mapping of keys of the scenario to their values"),
    ]
    seeds: Annotated[
        Annotated[int, Field(ge=1)] | Annotated[list[_Seed], Field(min_length=1)],
        Field(description="a number of seeds, at least 1, or a list of whole numbers from 0 on"),
    ] = 1
    measures: Annotated[_Names | None, Field(description="a list of measures")] = None
    series: Annotated[list[str], Field(description="a list of time series")] = Field(
        default_factory=list
    )
    engine: Annotated[SweepEngine, Field(description="one of auto, arrays, in-process")] = "auto"
    duration_s: Annotated[Positive | None, Field(description="a number in (0, 1e9]")] = None


@dataclass(frozen=True, kw_only=True)
class StudyFile:
    """A study, checked as far as it can be without its scenario."""

    name: str
    text: str
    scenario: str
    """Name of a built-in scenario, or path of a file."""
    description: str
    settings: tuple[str, ...]
    axes: Mapping[str, Axis]
    seeds: tuple[int, ...] | int
    """The seeds, or their number: 1, 2, and so on."""
    measures: tuple[str, ...] | None
    """None: every figure that the runs have and that needs no log."""
    series: tuple[str, ...]
    engine: SweepEngine
    duration_s: float | None
    places: Mapping[str, Place]
    """Where the axes and `axes`, `settings`, `seeds` and `scenario` are written."""

    @property
    def needs_log(self) -> bool:
        """Whether a measure is wanted that only a run with a log has."""
        return any(MEASURES[name].needs_log for name in self.measures or ())

    @property
    def seed_count(self) -> int:
        """Number of seeds."""
        return self.seeds if isinstance(self.seeds, int) else len(self.seeds)


def read_study(study: str | PathLike[str] | Mapping[str, Any]) -> StudyFile:
    """Return the study in a file, or that of a mapping with the same keys; raises BadStudyError."""
    if isinstance(study, Mapping):
        place = Place(source="study")
        text = json.dumps(study, indent=2, default=_plain, ensure_ascii=False)
        root, _ = parse(text, lambda _: place)
        return _study(root or Node({}, place), "sweep", text, None)
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
    return _study(root, path.stem, text, path.parent)


def _plain(value: object) -> object:
    """Return numpy's arrays and numbers, and paths, as JSON has them."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, PathLike):
        return fspath(value)
    raise bad_study("", f"a value of type {type(value).__name__} is not allowed")


def _study(root: Node, name: str, text: str, folder: Path | None) -> StudyFile:
    """Return the study that a tree describes; raises BadStudyError with all its problems."""
    if not isinstance(root.value, dict):
        raise bad_study("", f"{shown(root.plain())} is not a mapping", root.place)
    keys, problems = checked(StudyKeys, root, ())
    axes, in_axes = _axes(root.value.get("axes"))
    problems = [*problems, *in_axes]
    if keys is not None:
        problems += _names("measures", keys.measures or (), MEASURES, root)
        problems += _names("series", keys.series, SERIES, root)
        problems += _twice("seeds", keys.seeds if isinstance(keys.seeds, list) else (), root)
        problems += _settings_problems(keys.settings, axes, root)
    if keys is None or problems:
        raise BadStudyError(problems)
    places = {key: node.place for key, node in root.value.items()}
    places |= {key: root.place_of(("axes", key)) for key in axes}
    return StudyFile(
        name=name,
        text=text,
        scenario=_beside(folder, keys.scenario),
        description=keys.description,
        settings=tuple(_as_settings(keys.settings)),
        axes=axes,
        seeds=keys.seeds if isinstance(keys.seeds, int) else tuple(keys.seeds),
        measures=None if keys.measures is None else tuple(keys.measures),
        series=tuple(keys.series),
        engine=keys.engine,
        duration_s=keys.duration_s,
        places=places,
    )


def _axes(node: Node | None) -> tuple[dict[str, Axis], list[Problem]]:
    found: dict[str, Axis] = {}
    problems: list[Problem] = []
    entries = node.value if node is not None and isinstance(node.value, dict) else {}
    for key, written in entries.items():
        path = ("axes", key)
        if key in _OWN_KEYS:
            text = f"is no axis; use the key {_OWN_KEYS[key]} of the study"
            problems.append(Problem(key=".".join(path), text=text, place=written.place))
            continue
        is_list = isinstance(written.value, tuple)  # short for {values: [...]}
        one = Node({"values": written}, written.place) if is_list else written
        kind = _kind(one, path)
        if isinstance(kind, Problem):
            problems.append(kind)
            continue
        axis, of_axis = checked(kind, one, path)
        problems += of_axis
        if axis is not None:
            found[key] = axis
            values = getattr(axis, "values", ())
            problems += _twice(".".join((*path, "values")), values, one, ("values",))
    samples = {key: axis.size for key, axis in found.items() if axis.random}
    if len(set(samples.values())) > 1:
        each = ", ".join(f"{key}: {size}" for key, size in samples.items())
        text = f"random axes are drawn together, but their samples differ ({each})"
        assert node is not None
        problems.append(Problem(key="axes", text=text, place=node.place))
    return found, problems


def _kind(node: Node, path: tuple[str, ...]) -> type[Axis] | Problem:
    """Return the kind of axis that a mapping's keys say."""
    if isinstance(node.value, dict):
        if "distribution" in node.value:
            named = node.value["distribution"]
            if isinstance(named.value, str) and named.value in DISTRIBUTIONS:
                return DISTRIBUTIONS[named.value]
            text = f"{shown(named.plain())} is not one of {', '.join(DISTRIBUTIONS)}"
            return Problem(key=".".join((*path, "distribution")), text=text, place=named.place)
        if "values" in node.value:
            return Listed
        if node.value.keys() & {"from", "to", "steps"}:
            return Range
    text = f"{shown(node.plain())} is not an axis; allowed: values, or from, to and steps, or"
    return Problem(key=".".join(path), text=f"{text} distribution and samples", place=node.place)


def _names(
    key: str, names: Iterable[str], known: Mapping[str, object], root: Node
) -> Iterator[Problem]:
    names = list(names)
    for number, name in enumerate(names):
        if name not in known:
            place = root.place_of((key, number))
            yield Problem(key=f"{key}.{number}", text=unknown(name, list(known)), place=place)
    yield from _twice(key, names, root)


def _twice(
    key: str, values: Iterable[object], root: Node, path: tuple[str, ...] | None = None
) -> Iterator[Problem]:
    seen: set[str] = set()
    for number, value in enumerate(values):
        text = json.dumps(value, sort_keys=True)
        if text in seen:
            place = root.place_of((*(path or (key,)), number))
            what = f"{shown(value)} is given twice; allowed: once"
            yield Problem(key=f"{key}.{number}", text=what, place=place)
        seen.add(text)


def _settings_problems(
    settings: list[str] | dict[str, Any], axes: Iterable[str], root: Node
) -> Iterator[Problem]:
    of_settings = {setting.partition("=")[0].strip() for setting in _as_settings(settings)}
    for key in of_settings.intersection(axes):
        place = root.place_of(("settings",))
        yield Problem(key="settings", text=f"{key} is an axis of the study too", place=place)


def _as_settings(settings: list[str] | dict[str, Any]) -> list[str]:
    if isinstance(settings, list):
        return settings
    return [setting_of(key, value) for key, value in _flat(settings)]


def _flat(settings: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in settings.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", value


def setting_of(key: str, value: object) -> str:
    """Return a setting as on the command line: KEY=VALUE, with a value in JSON, which is YAML."""
    if isinstance(value, float) and not math.isfinite(value):
        return f"{key}={'.nan' if math.isnan(value) else '-.inf' if value < 0 else '.inf'}"
    return f"{key}={json.dumps(value, ensure_ascii=False)}"


def _beside(folder: Path | None, scenario: str) -> str:
    """Return the path of a scenario beside the study; else the name as it is."""
    if folder is not None and (folder / scenario).is_file():
        return str(folder / scenario)
    return scenario


OnLine = Callable[[str], None]
