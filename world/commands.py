"""Commands as columns: those of a cycle are a row per vehicle, however many processes send them."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from operator import attrgetter
from typing import Any, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.flat_arrays import DTYPES
from zenvoy.bus.flat_reading import Alike, FlatReader
from zenvoy.bus.topics import COMMAND

Floats = NDArray[np.float64]
Rows = NDArray[Any]

_FLAT: Final = FlatEncoder(pb.Command.DESCRIPTOR, leave_out=("neighbours", "timing", "logged"))
_NESTED: Final = ("ahead", "behind")
ROW: Final = np.dtype(
    [(one.name, "<u4" if one.code == "B" else DTYPES[one.code]) for one in _FLAT.pieces]
    + [("neighbours", "<u4")]
)
"""A command without its timing and what its law logs; `gap` of `ahead` is `ahead_gap`."""

_PATHS: Final = [
    next((name.replace("_", ".", 1) for side in _NESTED if name.startswith(f"{side}_")), name)
    for name in ROW.names or ()
]
_OF_MESSAGE: Final = attrgetter(*_PATHS)
_TIMES: Final = ("effective_ns", "age_ns", "ahead_measured_ns", "behind_measured_ns")


class Commands(NamedTuple):
    """Some commands of one cycle: rows of `ROW`, (k,), and what their laws log, (k, values).

    Values that a law does not log are NaN. alike: what the commands were read from; messages: the
    same, if they were read one by one.
    """

    rows: Rows
    logged: Floats
    alike: Sequence[Alike] = ()
    messages: Sequence[pb.Command] = ()

    @property
    def cycle(self) -> int:
        """The cycle of the commands."""
        return int(self.rows["cycle"][0])

    @property
    def time_ns(self) -> int:
        """The time of the decisions, ns."""
        return int(self.rows["time_ns"][0])


class CommandReader:
    """Reads commands; `values` is the greatest number of values that a law of the run logs."""

    def __init__(self, values: int) -> None:
        self._values = values
        self._reader: Final = FlatReader(pb.Command.DESCRIPTOR)

    def flat(self, payloads: Sequence[bytes]) -> Commands | None:
        """Return at least one command as columns; None if any is not flat (see `FlatReader`)."""
        alike = self._reader.read(payloads)
        if alike is None:
            return None
        found = self._empty(len(payloads))
        for at, fields in alike:
            names = set(fields.dtype.names or ())
            for name in names.intersection(ROW.names or ()):
                found.rows[name][at] = fields[name]
            if "logged" in names:
                count = min(fields["logged"].shape[1], self._values)
                found.logged[at, :count] = fields["logged"][:, :count]
        return found._replace(alike=alike)

    def each(self, payloads: Sequence[bytes]) -> Commands:
        """Return at least one command as columns, whatever their form."""
        flat = self.flat(payloads)
        if flat is not None:
            return flat
        messages = [COMMAND.decode(payload) for payload in payloads]
        found = self._empty(len(messages))
        for at, message in enumerate(messages):
            found.rows[at] = _OF_MESSAGE(message)
            count = min(len(message.logged), self._values)
            found.logged[at, :count] = message.logged[:count]
        return found._replace(messages=messages)

    def _empty(self, count: int) -> Commands:
        return Commands(np.zeros(count, ROW), np.full((count, self._values), nan))


class FleetCommands:
    """The commands of a fleet for a cycle, a row of `ROW` per vehicle.

    A vehicle without a command has NaN, and -1 for times.
    """

    def __init__(self, size: int, values: int) -> None:
        self.rows: Rows = np.full(size, _no_command())
        self.logged: Floats = np.full((size, values), nan)
        self.there = np.zeros(size, dtype=np.bool_)
        """Which vehicles have a command."""

    def put(self, commands: Commands) -> Self:
        """Enter the commands of some vehicles."""
        at = commands.rows["vehicle"].astype(np.intp) - 1
        self.rows[at], self.logged[at], self.there[at] = commands.rows, commands.logged, True
        return self


def _no_command() -> Rows:
    """Return the row of a vehicle that sent no command: nothing known, nothing decided."""
    row = np.zeros((), ROW)
    for name in ROW.names or ():
        if row.dtype[name].kind == "f":
            row[name] = nan
    for name in _TIMES:
        row[name] = -1
    return row
