"""Reads a study for `zenvoy tune` from a file or a mapping."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os import PathLike
from typing import Any, Final

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.scenarios import COMMAND_LINE, Problem, Spelling
from zenvoy.scenarios.reading.tree import Node
from zenvoy.studies.sweeps.checking import checked, entries, repeated, unknown
from zenvoy.studies.sweeps.errors import BadStudyError
from zenvoy.studies.sweeps.plan import MOST_RUNS
from zenvoy.studies.sweeps.study_file import run_problems, study_file, written
from zenvoy.studies.tuning.figures import FIGURES, is_theoretical
from zenvoy.studies.tuning.keys import Limits, Sampler, TuneKeys
from zenvoy.studies.tuning.parameters import Choices, Parameter, Span
from zenvoy.studies.tuning.study import Bound, Constraint, Direction, TuneStudy
from zenvoy.values.wording import shown

_OWN_KEYS: Final = {"seed": "seeds", "extends": "scenario", "duration_s": "duration_s"}
_DIRECTIONS: Final[tuple[Direction, ...]] = ("minimize", "maximize")
_BOUNDS: Final[tuple[Bound, ...]] = ("max", "min")


def read_tune_study(
    study: str | PathLike[str] | Mapping[str, Any],
    *,
    allow_code: bool = False,
    spelling: Spelling = COMMAND_LINE,
) -> TuneStudy:
    """Return the study in a file, or that of a mapping with the same keys; raises BadStudyError."""
    found = written(study, "tune")
    root = found.root
    keys, problems = checked(TuneKeys, root, ())
    parameters, in_parameters = _parameters(root.find(("parameters",)))
    constraints, in_constraints = _constraints(root.find(("constraints",)))
    sampler, in_sampler = _sampler(root.find(("sampler",)))
    problems = [*problems, *in_parameters, *in_constraints, *in_sampler]
    if keys is not None:
        problems += _objective_problems(keys, root)
        problems += run_problems(keys, parameters, "a parameter", root)
        problems += _size_problems(keys, root)
    if keys is None or sampler is None or problems:
        raise BadStudyError(problems)
    direction, figure = _objective(keys)
    measured = dict.fromkeys(
        name for name in (figure, *(c.figure for c in constraints)) if not is_theoretical(name)
    )
    problems += _log_problems(keys, measured, root)
    if problems:
        raise BadStudyError(problems)
    return TuneStudy(
        runs=study_file(
            found, keys, "parameters", axes={}, measures=tuple(measured), spelling=spelling
        ),
        parameters=parameters,
        direction=direction,
        figure=figure,
        constraints=constraints,
        trials=keys.trials,
        sampler=sampler,
        allow_code=allow_code,
    )


def _sampler(node: Node | None) -> tuple[Sampler | None, list[Problem]]:
    """Return the sampler and its problems; the check of keys reports a value that is no mapping."""
    if node is not None and not isinstance(node.value, dict):
        return None, []
    return (Sampler(), []) if node is None else checked(Sampler, node, ("sampler",))


def _parameters(node: Node | None) -> tuple[dict[str, Parameter], list[Problem]]:
    found: dict[str, Parameter] = {}
    problems: list[Problem] = []
    for key, entry in entries(node).items():
        path = ("parameters", key)
        if key in _OWN_KEYS:
            text = f"is no parameter; use the key {_OWN_KEYS[key]} of the study"
            problems.append(Problem(key=".".join(path), text=text, place=entry.place))
            continue
        if not isinstance(entry.value, dict) or not entry.value.keys() & {"low", "high", "choices"}:
            text = f"{shown(entry.plain())} is no parameter; allowed: low and high, or choices"
            problems.append(Problem(key=".".join(path), text=text, place=entry.place))
            continue
        kind: type[Parameter] = Choices if "choices" in entry.value else Span
        parameter, in_it = checked(kind, entry, path)
        if parameter is not None:
            found[key] = parameter
            in_it += _disagreements(parameter, entry, path)
        problems += in_it
    return found, problems


def _disagreements(parameter: Parameter, entry: Node, path: tuple[str, ...]) -> Iterator[Problem]:
    if isinstance(parameter, Choices):
        name = ".".join((*path, "choices"))
        yield from repeated(name, parameter.choices, entry, ("choices",))
    elif isinstance(parameter, Span) and parameter.problem is not None:
        key, text = parameter.problem
        yield Problem(key=".".join((*path, key)), text=text, place=entry.place_of((key,)))


def _constraints(node: Node | None) -> tuple[tuple[Constraint, ...], list[Problem]]:
    found: list[Constraint] = []
    problems: list[Problem] = []
    for figure, entry in entries(node).items():
        path = ("constraints", figure)
        if figure not in FIGURES:
            text = unknown(figure, list(FIGURES))
            problems.append(Problem(key=".".join(path), text=text, place=entry.place))
            continue
        limits, in_it = (
            checked(Limits, entry, path) if isinstance(entry.value, dict) else (None, [])
        )
        pairs = [] if limits is None else [(bound, getattr(limits, bound)) for bound in _BOUNDS]
        given = [(bound, limit) for bound, limit in pairs if limit is not None]
        if not given and not in_it:
            what = "has no limit" if limits is not None else f"{shown(entry.plain())} is no limit"
            text = f"{what}; allowed: max, min or both, with a number"
            problems.append(Problem(key=".".join(path), text=text, place=entry.place))
        elif len(given) == 2 and given[0][1] < given[1][1]:
            text = f"max {given[0][1]:g} is below min {given[1][1]:g}"
            problems.append(Problem(key=".".join(path), text=text, place=entry.place))
        problems += in_it
        found += [Constraint(figure=figure, bound=bound, limit=limit) for bound, limit in given]
    return tuple(found), problems


def _objective(keys: TuneKeys) -> tuple[Direction, str]:
    for direction in _DIRECTIONS:
        if (figure := getattr(keys, direction)) is not None:
            return direction, figure
    raise AssertionError("a study without an objective has a problem")


def _objective_problems(keys: TuneKeys, root: Node) -> Iterator[Problem]:
    given = [direction for direction in _DIRECTIONS if getattr(keys, direction) is not None]
    if not given:
        yield Problem(key="minimize", text="missing; allowed: a measure, also in maximize")
    if len(given) == 2:
        place = root.place_of(("maximize",))
        text = f"{shown(keys.maximize)} beside minimize; allowed: one of the two"
        yield Problem(key="maximize", text=text, place=place)
    for direction in given:
        name = getattr(keys, direction)
        if name not in FIGURES:
            place = root.place_of((direction,))
            yield Problem(key=direction, text=unknown(name, list(FIGURES)), place=place)


def _size_problems(keys: TuneKeys, root: Node) -> Iterator[Problem]:
    seeds = keys.seeds if isinstance(keys.seeds, int) else len(keys.seeds)
    if keys.trials * seeds > MOST_RUNS:
        text = f"{keys.trials:,} trials × {seeds:,} seeds are {keys.trials * seeds:,} runs;"
        place = root.place_of(("trials",))
        yield Problem(key="trials", text=f"{text} allowed: at most {MOST_RUNS:,}", place=place)


def _log_problems(keys: TuneKeys, measured: Mapping[str, None], root: Node) -> Iterator[Problem]:
    """Yield a problem for each measure that needs a log; the engine arrays makes none."""
    for name in measured if keys.engine == "arrays" else ():
        if MEASURES[name].needs_log:
            text = f"arrays; {name} is counted in a log; allowed: auto, in-process"
            yield Problem(key="engine", text=text, place=root.place_of(("engine",)))
