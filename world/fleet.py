"""True state of the fleet, moved by the commands that have taken effect."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Scenario
from zenvoy.world.contacts import Contacts
from zenvoy.world.dynamics import acting, advance
from zenvoy.world.events import Overrides
from zenvoy.world.road import Road

Floats = NDArray[np.float64]


class Fleet:
    """Positions (m, not wrapped), speeds (m/s) and accelerations (m/s²) at `time_ns`.

    All are (n,), or (runs, n) for several runs of a scenario side by side, which share the events
    and the instants at which commands take effect.
    """

    def __init__(self, scenario: Scenario, runs: int | None = None) -> None:
        fleet = scenario.fleet
        shape = (fleet.size,) if runs is None else (runs, fleet.size)
        self.time_ns = 0
        self.road = Road(scenario.ring_length_m)
        at_start = np.arange(fleet.size - 1.0, -1.0, -1.0) * fleet.gap_m
        self.position: Floats = np.broadcast_to(at_start, shape).copy()
        self.speed: Floats = np.full(shape, fleet.speed_mps)
        self.mean_acceleration: Floats = np.zeros(shape)
        self.gaps: Floats = self.road.gaps(self.position)
        """To the vehicle ahead, m; NaN for the first of the open road."""
        self._contacts = Contacts(self.road, fleet.length_m)
        self._limit = scenario.control.acceleration_limit_mps2
        self._overrides = Overrides(scenario)
        self._commanded: Floats = np.zeros(shape)
        self._coming: dict[int, list[tuple[int | slice, Floats | float]]] = {}

    @property
    def acceleration(self) -> Floats:
        """What acts from `time_ns` on, m/s²."""
        a = self._overrides.applied(self.time_ns, self._commanded, self.speed)
        return acting(self.speed, a)

    def command(self, commands: Iterable[pb.Command]) -> None:
        """Take in commands, to be applied when they take effect (at once, if that has passed)."""
        for command in commands:
            a = max(-self._limit, min(self._limit, command.acceleration))
            self._coming.setdefault(command.effective_ns, []).append((command.vehicle - 1, a))

    def let_roll(self, vehicle: int, from_ns: int) -> None:
        """Set the acceleration of a vehicle to 0 from an instant on, until its next command."""
        self._coming.setdefault(from_ns, []).append((vehicle - 1, 0.0))

    def command_all(self, effective_ns: int, a: Floats) -> None:
        """Take in a command for every vehicle, of the shape of `speed`."""
        limited = np.maximum(-self._limit, np.minimum(self._limit, a))
        self._coming.setdefault(effective_ns, []).append((slice(None), limited))

    def advance_to(self, time_ns: int) -> list[tuple[int, int]]:
        """Move to `time_ns`; returns who ran into the vehicle ahead: run and index, from 0."""
        start_ns, start_speed = self.time_ns, self.speed
        for until_ns in self._changes(time_ns):
            dt_s = (until_ns - self.time_ns) * 1e-9
            self.position, self.speed = advance(self.position, self.speed, self.acceleration, dt_s)
            self.time_ns = until_ns
            self._apply()
        if time_ns > start_ns:
            self.mean_acceleration = (self.speed - start_speed) / ((time_ns - start_ns) * 1e-9)
        self.gaps = self.road.gaps(self.position)
        collided = self._contacts.found(self.gaps, self.position, self.speed)
        if self._contacts.moved:
            self.gaps = self.road.gaps(self.position)
        return collided

    def _changes(self, time_ns: int) -> list[int]:
        """Instants up to `time_ns` at which an acceleration changes, and `time_ns`."""
        self._apply()
        changes = self._overrides.changes(self.time_ns, time_ns)
        changes.update(t for t in self._coming if t < time_ns)
        return [*sorted(changes), time_ns]

    def _apply(self) -> None:
        """Let the commands take effect whose time has come."""
        for effective_ns in sorted(t for t in self._coming if t <= self.time_ns):
            commanded = self._commanded.copy()
            for which, a in self._coming.pop(effective_ns):
                commanded[..., which] = a
            self._commanded = commanded
