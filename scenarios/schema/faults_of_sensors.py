"""Faults of sensors: blind, frozen, biased, drifting, jumping.

They act on the readings of a cycle, after the errors of `sensors`, in the order of the list.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Field

from zenvoy.scenarios.schema.fault import Amount, Amounts, Fault, signed
from zenvoy.values.section import Percent
from zenvoy.values.wording import trimmed

READINGS: Final = {
    "radar": ("gap", "relative_speed"),
    "position": ("position",),
    "speed": ("speed",),
    "acceleration": ("acceleration",),
    "all": ("gap", "relative_speed", "position", "speed", "acceleration"),
}
"""The readings of each sensor."""


class SensorBlind(Fault):
    """The radar reads nothing: its vehicle sees nobody ahead."""

    type: Literal["sensor-blind"]
    sensor: Literal["radar"] = "radar"
    """The only sensor whose reading may be missing."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        return f"{self.sensor} blind"


class SensorFrozen(Fault):
    """A sensor repeats the reading that it has when the fault begins."""

    type: Literal["sensor-frozen"]
    sensor: Literal["radar", "position", "speed", "acceleration", "all"]
    """Radar: gap and relative speed."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        which = "all sensors" if self.sensor == "all" else self.sensor
        return f"{which} frozen"


class _Off(Amounts):
    """Readings are off by amounts in their own units."""

    gap_m: Amount = 0.0
    """Error of the radar's gap."""
    relative_speed_mps: Amount = 0.0
    """Error of the radar's relative speed."""
    position_m: Amount = 0.0
    """Error of the position."""
    speed_mps: Amount = 0.0
    """Error of the speed."""
    acceleration_mps2: Amount = 0.0
    """Error of the acceleration."""


class SensorBiased(_Off):
    """Readings are off by constant amounts."""

    type: Literal["sensor-biased"]

    @property
    def words(self) -> str:
        """What goes wrong."""
        return f"sensor biased: {signed(self.amounts)}"


class SensorDrifting(Amounts):
    """Readings are off by amounts that grow in proportion to the time since the fault began."""

    type: Literal["sensor-drifting"]
    gap_mps: Amount = 0.0
    """Growth of the error of the radar's gap."""
    relative_speed_mps2: Amount = 0.0
    """Growth of the error of the radar's relative speed."""
    position_mps: Amount = 0.0
    """Growth of the error of the position."""
    speed_mps2: Amount = 0.0
    """Growth of the error of the speed."""
    acceleration_mps3: Amount = 0.0
    """Growth of the error of the acceleration."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        return f"sensor drifting: {signed(self.amounts)}"


class SensorJumping(_Off):
    """In a share of the cycles, drawn at random, readings are off by amounts up or down."""

    type: Literal["sensor-jumping"]
    share: Annotated[float, Field(gt=0, le=1), Percent] = 0.1
    """Probability of a jump in a cycle."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        amounts = signed(self.amounts).replace("+", "±").replace("-", "±")
        return f"sensor jumping: {amounts} in {trimmed(100 * self.share)} % of cycles"


SensorFault = SensorBlind | SensorFrozen | SensorBiased | SensorDrifting | SensorJumping
