"""Commands in real time: they wait for each other, and stay until their cycle is logged."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.world.commands import CommandReader, Commands, FleetCommands, joined

Ints = NDArray[np.int64]


class Arrived(NamedTuple):
    """Commands of one cycle, and when each arrived, ns, (k,)."""

    commands: Commands
    came_ns: Ints


@dataclass(slots=True)
class CycleCommands:
    """The commands of a cycle, as far as they have arrived: for the fleet, and part by part."""

    fleet: FleetCommands
    parts: list[Arrived] = field(default_factory=list)


@dataclass(slots=True)
class _Waiting:
    """Commands of a cycle: those of shared processes with their arrival, ns, and single ones."""

    together: list[tuple[Commands, int]] = field(default_factory=list)
    payloads: list[bytes] = field(default_factory=list)
    came_ns: list[int] = field(default_factory=list)


class RealtimeCommands:
    """The commands of a fleet of `size`; for each vehicle, their cycles ascend.

    Columns of a single command would take 0.35 ms to make. So commands wait, and those of one cycle
    become columns together.
    """

    def __init__(
        self, size: int, reader: CommandReader, no_commands: Callable[[], FleetCommands]
    ) -> None:
        self._reader: Final = reader
        self._no_commands = no_commands
        self._newest = np.full(size, -1)  # cycle of each vehicle's newest command
        self._waiting: defaultdict[int, _Waiting] = defaultdict(_Waiting)
        self._kept: dict[int, CycleCommands] = {}

    @property
    def wait_for_columns(self) -> bool:
        """Whether commands wait."""
        return bool(self._waiting)

    def are_newer(self, vehicles: Sequence[int], cycle: int) -> bool:
        """Return whether none of these vehicles has sent a command for a cycle, or a later one."""
        return all(self._newest.item(vehicle - 1) < cycle for vehicle in vehicles)

    def wait(self, vehicle: int, cycle: int, payload: bytes, came_ns: int) -> None:
        """Keep a command until `arrived`; it must be newer than all others of its vehicle."""
        self._newest[vehicle - 1] = cycle
        waiting = self._waiting[cycle]
        waiting.payloads.append(payload)
        waiting.came_ns.append(came_ns)

    def wait_together(self, commands: Commands, came_ns: int) -> None:
        """Keep commands of one cycle until `arrived`, each as `wait` does."""
        self._newest[commands.rows["vehicle"].astype(np.intp) - 1] = commands.cycle
        self._waiting[commands.cycle].together.append((commands, came_ns))

    def arrived(self) -> Iterator[Arrived]:
        """Yield the commands that have waited, by cycle. None takes effect before its arrival."""
        waiting, self._waiting = self._waiting, defaultdict(_Waiting)
        for _, those in sorted(waiting.items()):
            parts = [one for one, _ in those.together]
            came_ns = [np.full(len(one.rows), at_ns) for one, at_ns in those.together]
            if those.payloads:
                parts.append(self._reader.read(those.payloads))
                came_ns.append(np.array(those.came_ns))
            found = Arrived(joined(parts), np.concatenate(came_ns))
            rows = found.commands.rows
            rows["effective_ns"] = np.maximum(rows["effective_ns"], found.came_ns)
            yield found

    def keep(self, arrived: Arrived, oldest: int) -> None:
        """Keep commands until `take_out` asks for their cycle, if that is `oldest` or later."""
        cycle = arrived.commands.cycle
        if cycle < oldest:
            return
        if cycle not in self._kept:
            self._kept[cycle] = CycleCommands(self._no_commands())
        kept = self._kept[cycle]
        kept.fleet.put(arrived.commands)
        kept.parts.append(arrived)

    def parts(self, cycle: int) -> Sequence[Arrived]:
        """Return the commands of a cycle that have arrived so far."""
        return tuple(self._kept[cycle].parts) if cycle in self._kept else ()

    def take_out(self, cycle: int) -> CycleCommands:
        """Remove and return the commands of a cycle."""
        return self._kept.pop(cycle, None) or CycleCommands(self._no_commands())
