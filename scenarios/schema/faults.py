"""Faults on purpose: of sensors, transmitters, actuators and processes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

from pydantic import Field

from zenvoy.scenarios.schema.fault import Amount, Fault
from zenvoy.scenarios.schema.faults_of_processes import ProcessFault
from zenvoy.scenarios.schema.faults_of_sensors import SensorFault
from zenvoy.scenarios.schema.faults_of_transmitters import TransmitterFault
from zenvoy.scenarios.schema.roster import group_members
from zenvoy.scenarios.schema.sets import members

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario

F = TypeVar("F", bound=Fault)


class ActuatorStuck(Fault):
    """The acceleration stays as it is when the fault begins, or at acceleration_mps2.

    No command and no event changes it; a vehicle that has stopped does not roll backwards.
    """

    type: Literal["actuator-stuck"]
    acceleration_mps2: Amount | None = None
    """The acceleration at which it is stuck; null: that at the begin."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        at = self.acceleration_mps2
        return "actuator stuck" + ("" if at is None else f" at {at:g} m/s²")


AnyFault = Annotated[
    SensorFault | TransmitterFault | ActuatorStuck | ProcessFault, Field(discriminator="type")
]


def all_faults(scenario: Scenario) -> Iterator[tuple[int, Fault, tuple[int, ...]]]:
    """Yield the faults of a scenario: the index in `faults`, the fault, its vehicles in order."""
    groups = group_members(scenario)
    for index, fault in enumerate(scenario.faults):
        yield index, fault, tuple(sorted(members(fault.vehicles, scenario.fleet.size, groups)))


def faults_of(scenario: Scenario, kind: type[F]) -> Iterator[tuple[int, F, tuple[int, ...]]]:
    """Yield the faults of a kind, as `all_faults` does."""
    for index, fault, vehicles in all_faults(scenario):
        if isinstance(fault, kind):
            yield index, fault, vehicles
