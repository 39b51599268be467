"""The true state of the fleet, moved by the commands in effect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Scenario, roster
from zenvoy.world.actuators import Actuators
from zenvoy.world.contacts import Contacts
from zenvoy.world.dynamics import acting, advance
from zenvoy.world.events import Overrides
from zenvoy.world.road import Road
from zenvoy.world.stuck import StuckActuators

Floats = NDArray[np.float64]
Ints = NDArray[np.integer[Any]]


class Fleet:
    """Positions (m, not wrapped), speeds (m/s) and accelerations (m/s²) at `time_ns`.

    All are (n,). With `batch`, scenarios that differ from the first only in their seed, they are
    (runs, n): the runs share the events and the instants at which commands take effect.
    """

    def __init__(self, scenario: Scenario, batch: Sequence[Scenario] | None = None) -> None:
        fleet = scenario.fleet
        shape = (fleet.size,) if batch is None else (len(batch), fleet.size)
        self.time_ns = 0
        self.road = Road(scenario.ring_length_m)
        self.position: Floats = np.broadcast_to(fleet.positions_at_start_m, shape).copy()
        self.speed: Floats = np.broadcast_to(fleet.speeds_at_start_mps, shape).copy()
        self.mean_acceleration: Floats = np.zeros(shape)
        self.gaps: Floats = self.road.gaps(self.position)
        """Gaps to the vehicle ahead, m; NaN for the first vehicle of an open road."""
        self._contacts = Contacts(self.road, fleet.length_m)
        settings = [one for run in batch or [scenario] for one in roster(run)]
        self._lowest = np.array([one.limits.lowest for one in settings]).reshape(shape)
        self._highest = np.array([one.limits.highest for one in settings]).reshape(shape)
        lag_s = np.array([one.lag_s for one in settings]).reshape(shape)
        self._actuators = Actuators(lag_s) if lag_s.any() else None
        self._overrides = Overrides(scenario)
        self._stuck = StuckActuators(scenario)
        self._commanded: Floats = np.zeros(shape)
        self._coming: dict[int, list[tuple[int | slice | Ints, Floats | float]]] = {}

    @property
    def acceleration(self) -> Floats:
        """The accelerations that act at `time_ns`, m/s²."""
        a = self._asked()
        if self._actuators is not None:
            a = np.where(self._lags(), self._actuators.acceleration, a)
        return acting(self.speed, a)

    def _asked(self) -> Floats:
        """Return the accelerations that actuators are asked for at `time_ns`, or stuck at, m/s²."""
        a = self._overrides.applied(self.time_ns, self._commanded, self.speed)
        if not self._stuck.ruled(self.time_ns):
            return a
        given = a
        if self._actuators is not None:
            given = np.where(self._lags_if_free(), self._actuators.acceleration, a)
        return self._stuck.applied(self.time_ns, a, given)

    def command(self, vehicle: Ints, effective_ns: Ints, acceleration: Floats) -> None:
        """Take in commands (k,); each takes effect at its time, or at once if that has passed."""
        index = vehicle.astype(np.intp) - 1
        a = np.maximum(self._lowest[index], np.minimum(self._highest[index], acceleration))
        for at_ns in np.unique(effective_ns).tolist():
            then = effective_ns == at_ns
            self._coming.setdefault(at_ns, []).append((index[then], a[then]))

    def brake(self, vehicle: int, start_ns: int, end_ns: int, deceleration: float) -> None:
        """Let a vehicle brake between two instants, the first of them not before now."""
        self._overrides.brake(vehicle, start_ns, end_ns, deceleration)

    def let_roll(self, vehicle: int, from_ns: int, acceleration: float = 0.0) -> None:
        """Set the acceleration of a vehicle (m/s²) from an instant on, until its next command."""
        self._coming.setdefault(from_ns, []).append((vehicle - 1, acceleration))

    def command_all(self, effective_ns: int, a: Floats) -> None:
        """Take in a command for every vehicle, in the shape of `speed`."""
        limited = np.maximum(self._lowest, np.minimum(self._highest, a))
        self._coming.setdefault(effective_ns, []).append((slice(None), limited))

    def advance_to(self, time_ns: int) -> list[tuple[int, int]]:
        """Move to `time_ns`; return the new collisions: run and index of the follower, from 0."""
        start_ns, start_speed = self.time_ns, self.speed
        for until_ns in self._changes(time_ns):
            self._move((until_ns - self.time_ns) * 1e-9)
            self.time_ns = until_ns
            self._apply()
        if time_ns > start_ns:
            self.mean_acceleration = (self.speed - start_speed) / ((time_ns - start_ns) * 1e-9)
        self.gaps = self.road.gaps(self.position)
        collided = self._contacts.found(self.gaps, self.position, self.speed)
        if self._contacts.moved:
            self.gaps = self.road.gaps(self.position)
        return collided

    def _move(self, dt_s: float) -> None:
        """Move for dt_s, during which no command changes."""
        a = self._asked()
        position, speed = advance(self.position, self.speed, acting(self.speed, a), dt_s)
        if self._actuators is not None:
            moved, after = self._actuators.advance(self.position, self.speed, a, dt_s)
            lags = self._lags()
            position, speed = np.where(lags, moved, position), np.where(lags, after, speed)
            actual = self._actuators.acceleration
            self._actuators.acceleration = np.where(
                lags, actual, a
            )  # after an event, the lag starts from its value
        self.position, self.speed = position, speed

    def _lags(self) -> NDArray[np.bool_]:
        """Return which accelerations lag now: events act without lag, and what is stuck does."""
        lags = self._lags_if_free()
        lags[..., self._stuck.ruled(self.time_ns)] = False
        return lags

    def _lags_if_free(self) -> NDArray[np.bool_]:
        """Return which accelerations would lag now if no actuator were stuck."""
        assert self._actuators is not None
        lags = self._actuators.lagging.copy()
        lags[..., self._overrides.ruled(self.time_ns)] = False
        return lags

    def _changes(self, time_ns: int) -> list[int]:
        """Return the instants before `time_ns` at which an acceleration changes, then `time_ns`."""
        self._apply()
        changes = self._overrides.changes(self.time_ns, time_ns)
        changes |= self._stuck.changes(self.time_ns, time_ns)
        changes.update(t for t in self._coming if t < time_ns)
        return [*sorted(changes), time_ns]

    def _apply(self) -> None:
        """Apply the commands whose time of effect has come."""
        for effective_ns in sorted(t for t in self._coming if t <= self.time_ns):
            commanded = self._commanded.copy()
            for which, a in self._coming.pop(effective_ns):
                commanded[..., which] = a
            self._commanded = commanded
