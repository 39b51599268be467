"""Faults of transmitters: silent, babbling, repeating, lying."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from zenvoy.scenarios.schema.fault import Amount, Amounts, Fault, signed


class TransmitterSilent(Fault):
    """Nothing of the vehicle goes on the air."""

    type: Literal["transmitter-silent"]

    @property
    def words(self) -> str:
        """What goes wrong."""
        return "transmitter silent"


class TransmitterBabbling(Fault):
    """Besides its beacon the vehicle sends frames without meaning, one after the other.

    They contend for the medium, which must have carrier sense. What a period has no room for is
    dropped.
    """

    type: Literal["transmitter-babbling"]
    frames_per_cycle: Annotated[int, Field(ge=1, le=10_000)]
    """As many as a cycle has room for; the others are dropped."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        return f"transmitter babbles: {self.frames_per_cycle} frames per cycle"


class TransmitterRepeating(Fault):
    """Instead of each new beacon the last one before the fault goes on the air again.

    With new_times it says that it is new; without, its receivers drop it as an old one.
    """

    type: Literal["transmitter-repeating"]
    new_times: bool = False
    """True: the contents say that they are of now; false: receivers see that they are old, and drop
    them."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        return "transmitter repeats an old frame" + (" as new" if self.new_times else "")


class TransmitterLying(Amounts):
    """Values in beacons are off by constant amounts; gap_m is the radar reading in a beacon."""

    type: Literal["transmitter-lying"]
    position_m: Amount = 0.0
    """Error of the position in a beacon."""
    speed_mps: Amount = 0.0
    """Error of the speed in a beacon."""
    acceleration_mps2: Amount = 0.0
    """Error of the acceleration in a beacon, and of its plan and its command."""
    gap_m: Amount = 0.0
    """Error of the radar's gap in a beacon."""

    @property
    def words(self) -> str:
        """What goes wrong."""
        return f"transmitter lies: {signed(self.amounts)}"


TransmitterFault = TransmitterSilent | TransmitterBabbling | TransmitterRepeating | TransmitterLying
