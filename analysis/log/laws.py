"""Finds the law behind each mode of a log: from the library, or as the log describes it."""

from __future__ import annotations

import json
from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import Any, Final

from zenvoy.analysis.log.columns import Table
from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Column, Law, Linear, Setpoint, builtin
from zenvoy.scenarios import Control, parameters_of

Given = tuple[tuple[str, Any], ...]

_FALLBACK: Final = pb.MODE_FALLBACK_FM


@dataclass(frozen=True, kw_only=True)
class LoggedLaw:
    """A law as the log describes it, without its code.

    `linear` is the law linearised at its equilibrium, by parameters (as JSON), setpoint and m.
    """

    mode: int
    name: str
    reference: str
    version: str = ""
    columns: tuple[Column, ...] = ()
    colour: str | None = None
    looks_behind: bool = False
    counts_sides: bool = False
    predicts: bool = False
    linear: Mapping[tuple[str, Setpoint, int], Linear] | None = None
    law: Law | None = None
    """The law itself, if it is in the library."""

    def linear_at(
        self, control: Control, given: Given, setpoint: Setpoint, m: int
    ) -> Linear | None:
        """Return the law linearised at its equilibrium; None where that is not known."""
        if self.law is None:
            return (self.linear or {}).get((_key(dict(given)), setpoint, m))
        if self.law.linear is None:
            return None
        linear: Linear = self.law.linear(parameters_of(control, self.law, given), setpoint, m)
        return linear


def laws_in(metadata: Mapping[str, str], named: Container[str] = ()) -> dict[int, LoggedLaw]:
    """Return the laws by mode: those of the library, and those in the metadata zenvoy.laws.

    A law of the library logs its columns only in scenarios that name it; `named` has their models.
    Raises ValueError where the metadata cannot be understood.
    """
    laws = [law for law in builtin().values() if law.mode is not None]
    found = {law.mode or 0: _of_library(law, logs=law.name in named) for law in laws}
    found[_FALLBACK] = found[pb.MODE_FM]
    for mode, text in metadata.items():
        if mode.isdecimal():
            found[int(mode)] = _described(int(mode), text)
    return found


def own_laws_in(laws: Mapping[int, LoggedLaw]) -> dict[str, str]:
    """Return the reference and the package of each law that is not in the library, by name."""
    own = [law for _, law in sorted(laws.items()) if law.law is None]
    return {law.name: f"{law.reference} {law.version}".strip() for law in own}


def split_logged(table: Table, laws: Mapping[int, LoggedLaw], vehicles: int) -> dict[str, str]:
    """Replace `logged` with a column per value that a law logs, and return their units by name.

    Columns are named after law and value: `Smith.desired_gap`. Raises ValueError where `logged` has
    the wrong size.
    """
    if "logged" not in table:
        return {}
    logged = table.pop("logged")
    names = units_of(laws)
    if logged.shape[1] != len(names) * vehicles and (names or logged.size) and len(logged):
        raise ValueError(
            f"logged has {logged.shape[1]} numbers in a message, not {len(names)} times {vehicles}"
        )
    for number, name in enumerate(names):
        table[name] = logged[:, number * vehicles : (number + 1) * vehicles]
    return names


def units_of(laws: Mapping[int, LoggedLaw]) -> dict[str, str]:
    """Return the units of the values that laws log, by column, in the order of the log."""
    return {
        f"{law.name}.{column.name}": column.unit
        for mode, law in sorted(laws.items())
        for column in law.columns
        if mode != _FALLBACK
    }


def _of_library(law: Law, *, logs: bool) -> LoggedLaw:
    return LoggedLaw(
        mode=law.mode or 0,
        name=law.name,
        reference=law.name,
        columns=law.columns if logs else (),
        colour=law.colour,
        looks_behind=law.two_sided(),
        counts_sides=bool(law.needs.sides),
        predicts=law.needs.prediction,
        law=law,
    )


def _described(mode: int, text: str) -> LoggedLaw:
    try:
        facts = json.loads(text)
        return LoggedLaw(
            mode=mode,
            name=str(facts["name"]),
            reference=f"{facts['reference']}#{facts['source_hash']}",
            version=str(facts["version"]),
            columns=tuple(Column(str(name), str(unit)) for name, unit in facts["columns"]),
            colour=facts["colour"],
            looks_behind=bool(facts["looks_behind"]),
            counts_sides=bool(facts["counts_sides"]),
            predicts=bool(facts["predicts"]),
            linear={
                (_key(given), Setpoint(*map(float, setpoint)), int(m)): _linear(linear)
                for given, setpoint, m, linear in facts["linear"]
            },
        )
    except (KeyError, TypeError, RecursionError) as error:
        raise ValueError(f"the description of law {mode} is incomplete or malformed") from error


def _linear(values: Any) -> Linear:
    ahead, behind, k_d, k_v, k_c = values
    weights = (tuple(map(float, ahead)), tuple(map(float, behind)))
    return Linear(*weights, float(k_d), float(k_v), float(k_c))


def _key(given: Mapping[str, Any]) -> str:
    return json.dumps(given, sort_keys=True)
