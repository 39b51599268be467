"""Commands as columns: those of a cycle are a row per vehicle, however many processes send them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate
from math import nan
from operator import attrgetter
from types import MappingProxyType
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

_LEFT_OUT: Final = ("timing", "logged")
_FLAT: Final = FlatEncoder(pb.Command.DESCRIPTOR, _LEFT_OUT)
ROW: Final = np.dtype(
    [(one.name, "<u4" if one.code == "B" else DTYPES[one.code]) for one in _FLAT.pieces]
)
"""A command without its timing and what its law logs; `gap` of `ahead` is `ahead_gap`."""

_TIMES: Final = ("effective_ns", "age_ns", "ahead_measured_ns", "behind_measured_ns")


def _paths() -> Iterator[str]:
    """Yield the path of each field of `ROW` in a message, in order."""
    for field in sorted(pb.Command.DESCRIPTOR.fields, key=lambda one: one.number):
        if field.name in _LEFT_OUT:
            continue
        if field.message_type is None:
            yield field.name
        else:
            inner = sorted(field.message_type.fields, key=lambda one: one.number)
            yield from (f"{field.name}.{one.name}" for one in inner)


_OF_MESSAGE: Final = attrgetter(*_paths())


class Commands(NamedTuple):
    """Some commands of one cycle: rows of `ROW`, (k,), and what their laws log, (k, values).

    Values that a law does not log are NaN. alike: the fields of the rows that were read as columns;
    messages: the messages of all other rows, by row.
    """

    rows: Rows
    logged: Floats
    alike: Sequence[Alike] = ()
    messages: Mapping[int, pb.Command] = MappingProxyType({})

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
        return None if alike is None else self._columns_of(alike, len(payloads))

    def _columns_of(self, alike: Sequence[Alike], count: int) -> Commands:
        found = Commands(np.zeros(count, ROW), np.full((count, self._values), nan), alike)
        for at, fields in alike:
            names = set(fields.dtype.names or ())
            for name in names.intersection(ROW.names or ()):
                found.rows[name][at] = fields[name]
            if "logged" in names:
                count = min(fields["logged"].shape[1], self._values)
                found.logged[at, :count] = fields["logged"][:, :count]
        return found

    def read(self, payloads: Sequence[bytes]) -> Commands:
        """Return at least one command as columns, whatever their form."""
        alike, left = self._reader.read_most(payloads)
        found = self._columns_of(alike, len(payloads))
        messages = {at: COMMAND.decode(payloads[at]) for at in left}
        for at, message in messages.items():
            found.rows[at] = _OF_MESSAGE(message)
            count = min(len(message.logged), self._values)
            found.logged[at, :count] = message.logged[:count]
        return found._replace(messages=messages)


def joined(parts: Sequence[Commands]) -> Commands:
    """Return commands of one cycle, at least one, that were read in several parts."""
    if len(parts) == 1:
        return parts[0]
    starts = accumulate((len(one.rows) for one in parts), initial=0)
    alike, messages = list[Alike](), dict[int, pb.Command]()
    for start, one in zip(starts, parts, strict=False):
        alike += [Alike(start + at, fields) for at, fields in one.alike]
        messages |= {start + at: message for at, message in one.messages.items()}
    rows = np.concatenate([one.rows for one in parts])
    logged = np.concatenate([one.logged for one in parts])
    return Commands(rows, logged, alike, messages)


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
