"""What all faults have in common: whom they hit, and when."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Final

from pydantic import Field

from zenvoy.scenarios.schema.inputs import VehicleSet
from zenvoy.values.section import LARGEST, NS_PER_S, NonNegative, Positive, Section

Amount = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]

NEVER_NS: Final = 2**63 - 1
"""The end of a fault that lasts to the end of the run, ns."""


class Fault(Section):
    """A fault of vehicles from at_s on for duration_s (null: to the end of the run)."""

    type: str
    vehicles: VehicleSet
    """Its vehicles."""
    at_s: NonNegative
    """When it begins."""
    duration_s: Positive | None = None
    """How long it lasts; null: to the end of the run."""

    @property
    def start_ns(self) -> int:
        """When it begins."""
        return round(self.at_s * NS_PER_S)

    @property
    def end_ns(self) -> int:
        """When it ends; NEVER_NS if it lasts to the end of the run."""
        if self.duration_s is None:
            return NEVER_NS
        return round((self.at_s + self.duration_s) * NS_PER_S)

    def in_force(self, time_ns: int) -> bool:
        """Return whether the fault is in force at a time: from its begin on, before its end."""
        return self.start_ns <= time_ns < self.end_ns

    @property
    @abstractmethod
    def words(self) -> str:
        """What goes wrong, for the log and for people: "radar blind"."""


class Amounts(Fault):
    """A fault that changes values by amounts; those that are 0 do not change."""

    @property
    def keys_of_amounts(self) -> tuple[str, ...]:
        """The keys that are amounts, which all name a unit with metres."""
        return tuple(name for name in type(self).model_fields if "_m" in name)

    @property
    def amounts(self) -> dict[str, float]:
        """The amounts that are not 0, by key."""
        given = {name: getattr(self, name) for name in self.keys_of_amounts}
        return {name: value for name, value in given.items() if value != 0.0}


def signed(amounts: dict[str, float]) -> str:
    """Return amounts with their units: "gap +5 m, speed -1 m/s"."""
    return ", ".join(f"{_name(key)} {value:+g} {_unit(key)}" for key, value in amounts.items())


_UNITS: Final = {
    "_mps3": "m/s³",
    "_mps2": "m/s²",
    "_mps": "m/s",
    "_m": "m",
}


def _name(key: str) -> str:
    return reading_of(key).replace("_", " ")


def reading_of(key: str) -> str:
    """Return the value that a key is about: "relative_speed" for "relative_speed_mps"."""
    return next(key.removesuffix(suffix) for suffix in _UNITS if key.endswith(suffix))


def _unit(key: str) -> str:
    return next(unit for suffix, unit in _UNITS.items() if key.endswith(suffix))
