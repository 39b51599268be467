"""When vehicles fall back to FM, and when they return to their own law."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb

_FALLS_BACK: Final = pb.MODE_FALLBACK_FM


class Fallbacks:
    """Which of `size` vehicles have fallen back, as far as their commands say."""

    def __init__(self, size: int) -> None:
        self._fallen_back = np.zeros(size, dtype=np.bool_)

    def take_in(self, at: NDArray[np.intp], mode: NDArray[Any]) -> list[tuple[int, bool]]:
        """Take in modes of vehicles, by index; return who changes, and whether it falls back."""
        falls = mode == _FALLS_BACK
        changed = at[falls != self._fallen_back[at]]
        self._fallen_back[at] = falls
        return [(index, bool(self._fallen_back[index])) for index in changed.tolist()]


def fallback_event(vehicle: int, begins: bool, time_ns: int) -> pb.Event:
    """Return the event that a vehicle falls back, or returns to its law."""
    kind = pb.EVENT_FALLBACK if begins else pb.EVENT_FALLBACK_END
    return pb.Event(time_ns=time_ns, kind=kind, vehicle=vehicle)
