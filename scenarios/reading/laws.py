"""Finds the code of the laws and estimators that a scenario names, and checks their parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path as FilePath
from typing import Any

from pydantic import BaseModel, ValidationError

from zenvoy.laws import Law, builtin, law_of
from zenvoy.laws.by_name import (
    ESTIMATORS,
    LAWS,
    Kind,
    has_entry_point,
    resolve,
)
from zenvoy.laws.code import CodeElsewhereError
from zenvoy.laws.errors import LawError, UnknownLawError, errors_of_the_code, raised
from zenvoy.laws.parameters import model_of
from zenvoy.laws.table import estimator_of
from zenvoy.scenarios.errors import InvalidScenarioError, Problem
from zenvoy.scenarios.reading.explain import Refusal, explained
from zenvoy.scenarios.reading.origin import Origin
from zenvoy.scenarios.reading.tree import Node, Path, planted
from zenvoy.scenarios.schema.own_laws import own_laws
from zenvoy.scenarios.schema.scenario import Scenario
from zenvoy.values.wording import dotted, shown

_CONTROL: Path = ("control",)


def with_laws(
    root: Node, origins: Mapping[str, Origin], *, allow_code: bool, to_allow: str
) -> tuple[Node, list[Problem]]:
    """Return `root` after loading the scenario's own laws, and the problems with them.

    Each reference gets the hash of its source. The parameters of all laws are filled in. Loading a
    law runs its code, which must lie beside the scenario or in an installed package unless
    `allow_code`. Messages name `to_allow` as what allows it.
    """
    problems: list[Problem] = []
    for path, key, kind in _sections(root):
        section = root.find(path)
        assert section is not None
        named = section.child(key)
        law = _with_own_parameters(named, kind)
        if law is not None:
            root, found = _with_parameters(root, path, law.name, law.parameters)
            problems += found
            continue
        if named is None or not isinstance(named.value, str) or not _is_code(named.value, kind):
            if wrong := _without_code(section, path, kind):
                problems += wrong
                root = _without(root, path)
            continue
        try:
            full = resolve(named.value, _folder(named, origins), kind, allow_code=allow_code)
        except UnknownLawError as error:
            hint = f"; {to_allow} runs it" if isinstance(error, CodeElsewhereError) else ""
            text = f"{shown(named.value)}: {error}{hint}"
            problems.append(Problem(key=dotted((*path, key)), text=text, place=named.place))
            continue
        root = planted(root, (*map(str, path), key), replace(named, value=full))
        record = law_of(full) if kind is LAWS else estimator_of(full)
        root, found = _with_parameters(root, path, full, record.parameters)
        problems += found
    return root, problems


def _sections(root: Node) -> Iterator[tuple[Path, str, Kind]]:
    """Yield the path of each section that may name code, the key that names it, and its kind.

    The law of the whole fleet comes before those of groups and of the schedule.
    """
    for path in (_CONTROL, ("control", "schedule"), ("fleet", "groups"), ("estimator",)):
        key, kind = ("model", LAWS) if path[0] != "estimator" else ("kind", ESTIMATORS)
        node = root.find(path)
        if node is None:
            continue
        if isinstance(node.value, dict):
            yield path, key, kind
        elif isinstance(node.value, tuple):
            for index, entry in enumerate(node.value):
                if isinstance(entry.value, dict):
                    yield (*path, index), key, kind


def _with_own_parameters(named: Node | None, kind: Kind) -> Law | None:
    """Return the law of the library that a section names, if `parameters` holds its parameters."""
    name = named.value if named is not None and kind is LAWS else None
    law = builtin().get(name) if isinstance(name, str) else None
    return law if law is not None and law.section is None and fields(law.parameters) else None


def _is_code(name: str, kind: Kind) -> bool:
    return ":" in name or (name not in kind.taken() and has_entry_point(name, kind))


def _folder(model: Node, origins: Mapping[str, Origin]) -> FilePath | None:
    """Return the folder of the scenario that names the law; for an option, of the main scenario."""
    origin = origins.get(model.place.source) or next(iter(origins.values()), None)
    if origin is None or origin.builtin:
        return FilePath()
    return FilePath(origin.source).parent


def _without_code(section: Node, path: Path, kind: Kind) -> list[Problem]:
    """Return a problem if a section has parameters but no law that takes them."""
    parameters, model = section.child("parameters"), section.child("model")
    if parameters is None or parameters.value in ({}, None):
        return []
    name = model.value if model is not None else None
    law = builtin().get(name) if isinstance(name, str) else None
    if kind is LAWS and name is not None and law is None:
        return []  # the model is wrong, which is reported elsewhere
    if kind is ESTIMATORS:
        text = "given, but the built-in estimators have none; allowed with kind: file:NAME"
    elif law is None:
        text = "given without a model; allowed with the model of a law that has parameters"
    elif law.section is not None:
        text = f"given, but {law.name} has its parameters in control.{law.section}"
    else:
        text = f"given, but {law.name} has no parameters"
    return [Problem(key=dotted((*path, "parameters")), text=text, place=parameters.place)]


def _with_parameters(
    root: Node, path: Path, full: str, parameters: type
) -> tuple[Node, list[Problem]]:
    """Return `root` with all parameters of a law: given here, given for the fleet, or defaults."""
    section = root.find(path)
    assert section is not None
    given = section.child("parameters")
    if given is None and path != _CONTROL and _model_of_all(root) == full:
        given = root.find((*_CONTROL, "parameters"))
    values = {} if given is None else given.plain()
    where = (*path, "parameters")
    place = section.place if given is None else given.place
    try:
        checked = _checked(parameters, frozen(values))
    except ValidationError as refused:
        problems = list(_problems(refused, parameters, where, root))
        return _without(root, path), problems  # so that no later check fails on them
    except LawError as error:
        problem = Problem(key=dotted(where), text=str(error), place=place)
        return _without(root, path), [problem]
    node = as_node(checked.model_dump(mode="json"), place)
    if given is not None:
        node = _placed_as(node, given)
    return planted(root, tuple(map(str, where)), node), []


def _checked(parameters: type, values: object) -> BaseModel:
    """Return the values as checked by the model of a dataclass and by the dataclass itself.

    Raises ValidationError if a type does not fit, and LawError for any error of the dataclass.
    """

    def failed(error: BaseException) -> LawError:
        return raised(parameters.__name__, parameters, error)

    model = model_of(parameters)
    checked = model.model_validate(values)
    with errors_of_the_code(failed):
        parameters(**{name: getattr(checked, name) for name in model.model_fields})
    return checked


def require_linear_forms(scenario: Scenario, root: Node) -> None:
    """Raise InvalidScenarioError if the linear form of a law cannot be computed."""
    try:
        own_laws(scenario)
    except LawError as error:
        path = (*_CONTROL, "model")
        problem = Problem(key=dotted(path), text=str(error), place=root.place_of(path))
        raise InvalidScenarioError([problem], 0) from error


def _without(root: Node, path: Path) -> Node:
    """Return `root` without the parameters in a section."""
    section = root.find(path)
    assert section is not None
    if not isinstance(section.value, dict):
        return root
    entries = {key: child for key, child in section.value.items() if key != "parameters"}
    return planted(root, tuple(map(str, path)), replace(section, value=entries))


def _model_of_all(root: Node) -> object:
    node = root.find((*_CONTROL, "model"))
    return None if node is None else node.value


def _problems(
    refused: ValidationError, parameters: type, where: Path, root: Node
) -> Iterator[Problem]:
    schema = model_of(parameters).model_json_schema()
    for error in refused.errors(include_url=False):
        loc, kind = error["loc"], error["type"]
        if not loc:
            text = f"{shown(error['input'])} is not a mapping"
            yield Problem(key=dotted(where), text=text, place=root.place_of(where))
            continue
        if kind == "finite_number":
            key = dotted((*where, *loc))
            text = f"{shown(error['input'])} is not a finite number"
            yield Problem(key=key, text=text, place=root.place_of((*where, *loc)))
            continue
        known = schema["properties"].get(loc[0])
        of = schema if kind == "extra_forbidden" or known is None else known
        yield explained(Refusal((*where, *loc[:1]), kind, error["input"], of), root)


def frozen(value: object) -> Any:
    """Return the value with lists replaced by tuples, for a frozen dataclass."""
    if isinstance(value, list):
        return tuple(frozen(item) for item in value)
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return value


def as_node(value: Any, place: Any) -> Node:
    """Return a plain value as a tree, with all nodes at one place."""
    if isinstance(value, dict):
        return Node({key: as_node(item, place) for key, item in value.items()}, place)
    if isinstance(value, list | tuple):
        return Node(tuple(as_node(item, place) for item in value), place)
    return Node(value, place)


def _placed_as(node: Node, given: Node) -> Node:
    """Return `node` with each entry that was given at the place where it was written."""
    if not isinstance(node.value, dict) or not isinstance(given.value, dict):
        return node
    entries = {
        key: replace(child, place=given.value[key].place) if key in given.value else child
        for key, child in node.value.items()
    }
    return replace(node, value=entries)
