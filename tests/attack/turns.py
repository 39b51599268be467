"""World and attacker take turns."""

from __future__ import annotations

import os
from typing import Final

from zenvoy.bus import messages_pb2 as pb


class Turns:
    """The world announces its cycle, and in lock-step waits until the attacker is done.

    So every cycle has the same number of mutants, however busy the machine is. The mutants of two
    cycles must fit in a queue of the world, which reads none while it waits here.
    """

    def __init__(self, *, realtime: bool) -> None:
        self._realtime = realtime
        self._cycles, self._answers = os.pipe(), os.pipe()

    def take(self, clock: pb.Clock) -> None:
        """Announce the cycle, and wait. The world calls this."""
        os.write(self._cycles[1], clock.cycle.to_bytes(_BYTES))
        if not self._realtime:
            os.read(self._answers[0], 1)

    def next(self) -> int:
        """Return the next cycle as soon as it has begun. The attacker calls this."""
        return int.from_bytes(os.read(self._cycles[0], _BYTES))

    def done(self) -> None:
        """Let the world go on. The attacker calls this."""
        os.write(self._answers[1], b"\0")


_BYTES: Final = 4
