"""The record of a user's own law is checked before a run, so that no run is lost to it."""

from __future__ import annotations

from dataclasses import dataclass, field, make_dataclass
from typing import Any

import numpy as np
import pytest

from zenvoy.laws import Column, Estimator, Law, Needs, builtin
from zenvoy.laws.checks import why_refused


@dataclass(frozen=True)
class Good:
    """Parameters of every kind that may be used."""

    needed: float
    gain: float = 1
    count: int = 2
    mode: str = "soft"
    weights: tuple[float, ...] = (0.5, 0.5)
    limit: float | None = None


def of_one(kind: Any, default: Any) -> type:
    """Return a dataclass with one parameter `k`, of a type and with a default that may be wrong."""
    return make_dataclass("Parameters", [("k", kind, default)], frozen=True)


WRONG_DEFAULT = of_one(float, "one")
UNKNOWN_TYPE = of_one("Foo", 1.0)
OF_ARRAYS = of_one(np.ndarray, field(default_factory=lambda: np.zeros(2)))
OF_LISTS = of_one(list[float], field(default_factory=list))


def raising() -> float:
    raise RuntimeError("no default today")


FAILING_DEFAULT = of_one(float, field(default_factory=raising))


class Plain:
    k = 1.0


def still(*_: object) -> Any:
    """Return no acceleration."""
    return 0.0


@pytest.mark.parametrize("law", builtin().values(), ids=list(builtin()))
def test_the_laws_of_the_library_can_be_used(law: Law) -> None:
    assert why_refused(law) is None


def test_a_law_with_all_fields_can_be_used() -> None:
    law = Law(
        name="Follow the leader 2",
        acceleration=still,
        parameters=Good,
        needs=Needs(sides="count", commands=True),
        columns=(Column("wanted", "m/s"), Column("error")),
        state=(0.0, 1),
        colour="#00aAfF",
        linear=still,
    )
    assert why_refused(law) is None


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"name": ""}, "name is ''; allowed: text in one line"),
        ({"name": 5}, "name is 5; allowed: text in one line"),
        ({"acceleration": 1.0}, "acceleration is 1.0; allowed: a function"),
        ({"parameters": Good(needed=1.0)}, "allowed: a dataclass (the class itself)"),
        ({"parameters": Plain}, "allowed: a dataclass (the class itself)"),
        ({"parameters": WRONG_DEFAULT}, "k = 'one'"),
        ({"parameters": UNKNOWN_TYPE}, "(NameError: name 'Foo' is not defined)"),
        ({"parameters": OF_ARRAYS}, "allowed: a dataclass of numbers, text and tuples"),
        ({"parameters": OF_LISTS}, "(list can change)"),
        ({"parameters": FAILING_DEFAULT}, "(RuntimeError: no default today)"),
        ({"needs": {"behind": True}}, "needs is {'behind': True}; allowed: Needs(…)"),
        ({"needs": Needs(sides="nope")}, "needs.sides is 'nope'; allowed: 0 to 100, or the name"),
        ({"needs": Needs(sides=-2)}, "needs.sides is -2"),
        ({"needs": Needs(commands="nope")}, "needs.commands is 'nope'"),
        ({"columns": ("x",)}, "columns is ('x',); allowed: a tuple of Column(name, unit)"),
        ({"columns": Column("x", "m")}, "columns is Column(name='x', unit='m')"),
        ({"columns": (Column("x"), Column("x", "m"))}, "with different names"),
        ({"columns": (Column("x\ny"),)}, "each text in one line"),
        ({"columns": (Column._make(("x", 1)),)}, "each text in one line"),
        ({"state": 0.0}, "state is 0.0; allowed: a tuple of numbers"),
        ({"state": ("nan",)}, "state is ('nan',)"),
        ({"colour": "redd"}, "colour is 'redd'; allowed: None or #RRGGBB"),
        ({"colour": 5}, "colour is 5"),
        ({"linear": 1.0}, "linear is 1.0"),
        ({"version": 2}, "version is 2"),
    ],
)
def test_a_wrong_field_is_named_with_its_value(fields: dict[str, Any], expected: str) -> None:
    why = why_refused(Law(**{"name": "mine", "acceleration": still, **fields}))
    assert why is not None
    assert expected in why
    assert "\n" not in why


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"name": None}, "name is None"),
        ({"start": "x"}, "start is 'x'; allowed: a function or a class"),
        ({"parameters": WRONG_DEFAULT}, "k = 'one'"),
    ],
)
def test_a_wrong_field_of_an_estimator_is_named(fields: dict[str, Any], expected: str) -> None:
    why = why_refused(Estimator(**{"name": "mine", "start": still, **fields}))
    assert why is not None
    assert expected in why
