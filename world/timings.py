"""What the commands of a cycle report in real time about their timing, as columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.world.commands import Commands

Rows = NDArray[Any]

_PREFIX: Final = "timing_"
_TIMES: Final = {"sensed_ns": -1, "decided_ns": -1, "clock_offset_ns": 0, "clock_error_ns": -1}
_OF_FRAMES: Final = ("source", "arrived_ns", "came_ns")
FRAME: Final = np.dtype([(name, "<i8") for name in ("destination", *_OF_FRAMES)])
"""A frame that a command reports: the vehicle of the command, the sender, and its times, ns."""


class Timings:
    """The timing of the commands of a fleet for a cycle. Times are (size,).

    parts: commands, and when each arrived, as for `put`.
    """

    def __init__(self, size: int, parts: Iterable[tuple[Commands, NDArray[np.int64]]] = ()) -> None:
        self.commanded_ns = np.full(size, -1)
        """When the command of a vehicle arrived; -1: not at all."""
        self.times = {name: np.full(size, default) for name, default in _TIMES.items()}
        """The times of `pb.Timing`, by name; -1, and an offset of 0, if none is known."""
        self._frames: list[Rows] = []
        for commands, came_ns in parts:
            self.put(commands, came_ns)

    @property
    def frames(self) -> Rows:
        """The frames that the commands report, in order of vehicle: rows of `FRAME`."""
        frames = np.concatenate([np.zeros(0, FRAME), *self._frames])
        return frames[np.argsort(frames["destination"], kind="stable")]

    def put(self, commands: Commands, came_ns: NDArray[np.int64]) -> None:
        """Enter the timing of commands, (k,), and when each arrived, ns, (k,)."""
        vehicles = commands.rows["vehicle"].astype(np.intp)
        self.commanded_ns[vehicles - 1] = came_ns
        for at, fields in commands.alike:
            self._put(vehicles[at], _timing_in(fields))
        for row, message in commands.messages.items():
            if message.HasField("timing"):
                timing = message.timing
                columns = {
                    name: np.array([getattr(timing, name)]) for name in (*_TIMES, *_OF_FRAMES)
                }
                self._put(vehicles[[row]], columns)

    def _put(self, vehicles: NDArray[np.intp], reported: Mapping[str, NDArray[Any]]) -> None:
        """Enter the timing of vehicles, (k,), by field; columns of frames are (k, frames)."""
        if not reported:
            return
        for name, times in self.times.items():
            times[vehicles - 1] = reported.get(name, 0)
        if "source" in reported:
            frames = np.zeros(reported["source"].shape, FRAME)
            frames["destination"] = vehicles[:, np.newaxis]
            for name in _OF_FRAMES:
                frames[name] = reported[name]
            self._frames.append(frames.ravel())


def are_timings(commands: Commands, size: int, most_error_ns: int) -> bool:
    """Return whether the timing of commands that were read together makes sense in a fleet.

    Then the columns of each match, the frames come from vehicles of a fleet of `size`, and the
    machines know the world's clock well enough.
    """
    return all(_is_timing(_timing_in(fields), size, most_error_ns) for _, fields in commands.alike)


def _is_timing(reported: Mapping[str, NDArray[Any]], size: int, most_error_ns: int) -> bool:
    error_ns = reported.get("clock_error_ns", np.zeros(1))
    if (error_ns < 0).any() or (error_ns > most_error_ns).any():
        return False
    shapes = [reported[name].shape if name in reported else None for name in _OF_FRAMES]
    if len(set(shapes)) > 1:
        return False
    source = reported.get("source", np.ones(1))
    return bool((source >= 1).all() and (source <= size).all())


def _timing_in(fields: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return the timing in messages of one form, by name of field; empty if they have none."""
    return {
        name.removeprefix(_PREFIX): fields[name]
        for name in fields.dtype.names or ()
        if name.startswith(_PREFIX)
    }
