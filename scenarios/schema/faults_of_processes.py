"""Faults of vehicles' processes: killed, frozen, slowed."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from zenvoy.scenarios.schema.fault import Fault
from zenvoy.values.section import LARGEST, NS_PER_MS, Positive


class ProcessKilled(Fault):
    """The vehicle's process is killed; on_vehicle_loss says what the vehicle does then.

    With on_vehicle_loss restart a new process joins after duration_s, with an empty filter; else
    the vehicle is lost to the end of the run. With brake it brakes with deceleration_mps2.
    """

    type: Literal["process-killed"]
    deceleration_mps2: Positive = 3.0
    """With on_vehicle_loss brake: how hard the vehicle brakes."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        return "process killed"


class ProcessFrozen(Fault):
    """The process stops: it takes in nothing and sends nothing, and its last command stays."""

    type: Literal["process-frozen"]

    @property
    def words(self) -> str:
        """What goes wrong."""
        return "process frozen"


class ProcessSlowed(Fault):
    """Commands decided while the fault is in force take effect later by delay_ms."""

    type: Literal["process-slowed"]
    delay_ms: Annotated[float, Field(gt=0, le=LARGEST)]
    """By how much."""

    @property
    def delay_ns(self) -> int:
        """By how much commands are late, ns."""
        return round(self.delay_ms * NS_PER_MS)

    @property
    def words(self) -> str:
        """What goes wrong."""
        return f"process slowed: commands {self.delay_ms:g} ms late"


ProcessFault = ProcessKilled | ProcessFrozen | ProcessSlowed
