"""Events of a scenario that override the controllers of vehicles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Brake, Scenario, Sine, Trace
from zenvoy.world.profiles import Following, SineProfile, TraceProfile

Floats = NDArray[np.float64]


class Override(Protocol):
    """Sets the acceleration of a vehicle while it is in force."""

    @property
    def vehicle(self) -> int:
        """Number of the vehicle, from 1."""
        ...

    def changes(self, after_ns: int, before_ns: int) -> Iterator[int]:
        """Return the instants between the two times at which the acceleration changes."""
        ...

    def in_force(self, time_ns: int) -> bool:
        """Return whether the override is in force from `time_ns` on."""
        ...

    def acceleration(self, time_ns: int, speed: Floats) -> Floats | float | None:
        """Return the acceleration from `time_ns` on (m/s²), or None while not in force.

        speed: at `time_ns`, m/s.
        """
        ...


@dataclass(frozen=True, slots=True)
class Braking:
    """A vehicle brakes at `deceleration` (m/s²) in [start_ns, end_ns)."""

    vehicle: int
    start_ns: int
    end_ns: int
    deceleration: float

    def changes(self, after_ns: int, before_ns: int) -> Iterator[int]:
        """Return the start and the end of the brake if they lie between the two times."""
        return (t for t in (self.start_ns, self.end_ns) if after_ns < t < before_ns)

    def in_force(self, time_ns: int) -> bool:
        """Return whether the vehicle brakes at `time_ns`."""
        return self.start_ns <= time_ns < self.end_ns

    def acceleration(self, time_ns: int, speed: Floats) -> float | None:
        """Return the acceleration (m/s², negative) while the vehicle brakes, else None."""
        return -self.deceleration if self.in_force(time_ns) else None


class Returning:
    """After a brake, a vehicle returns to the speed that it had when the brake began."""

    def __init__(self, brake: Brake) -> None:
        self.vehicle = brake.vehicle
        self._brakes_ns, self._start_ns, self._end_ns = (
            brake.start_ns,
            brake.end_ns,
            brake.returned_ns,
        )
        self._before: Floats | None = None

    def changes(self, after_ns: int, before_ns: int) -> Iterator[int]:
        """Return the start and the end of the brake, and the end of the return, in between."""
        times = (self._brakes_ns, self._start_ns, self._end_ns)
        return (t for t in times if after_ns < t < before_ns)

    def in_force(self, time_ns: int) -> bool:
        """Return whether the vehicle is returning at `time_ns`."""
        return self._start_ns <= time_ns < self._end_ns

    def acceleration(self, time_ns: int, speed: Floats) -> Floats | None:
        """Return the constant acceleration (m/s²) of the return, else None.

        The fleet calls this at every change, so also at the start of the brake, where the speed to
        return to is noted.
        """
        if self._before is None and time_ns >= self._brakes_ns:
            self._before = speed.copy()
        if self._before is None or not self.in_force(time_ns):
            return None
        return np.asarray((self._before - speed) / ((self._end_ns - time_ns) * 1e-9))


class Overrides:
    """All events of a scenario that set accelerations.

    Brakes override speed profiles, and these override returns from brakes. Of several brakes, the
    hardest counts.
    """

    def __init__(self, scenario: Scenario) -> None:
        brakes = sorted(scenario.brakes, key=lambda brake: brake.deceleration_mps2)
        # Later entries override earlier ones.
        self._all: list[Override] = [
            *(Returning(brake) for brake in brakes if brake.return_s is not None),
            *(_following(event, scenario.period_ns) for event in scenario.profiles),
            *(_braking(brake) for brake in brakes),
        ]

    def brake(self, vehicle: int, start_ns: int, end_ns: int, deceleration: float) -> None:
        """Let a vehicle brake that the scenario does not let brake; this overrides the scenario."""
        self._all.append(Braking(vehicle, start_ns, end_ns, deceleration))

    def changes(self, after_ns: int, before_ns: int) -> set[int]:
        """Return the instants between the two times at which an acceleration changes."""
        return {t for override in self._all for t in override.changes(after_ns, before_ns)}

    def ruled(self, time_ns: int) -> list[int]:
        """Return the indices of the vehicles under an event from `time_ns` on."""
        return [override.vehicle - 1 for override in self._all if override.in_force(time_ns)]

    def applied(self, time_ns: int, a: Floats, speed: Floats) -> Floats:
        """Return the accelerations from `time_ns` on (…, n): `a`, with the overrides in force.

        speed: at `time_ns`, m/s, (…, n).
        """
        applied = a
        for override in self._all:
            index = override.vehicle - 1
            value = override.acceleration(time_ns, speed[..., index])
            if value is None:
                continue
            if applied is a:
                applied = a.copy()
            applied[..., index] = value
        return applied


def _braking(brake: Brake) -> Braking:
    return Braking(brake.vehicle, brake.start_ns, brake.end_ns, brake.deceleration_mps2)


def _following(event: Sine | Trace, period_ns: int) -> Following:
    if isinstance(event, Sine):
        return Following(event.vehicle, SineProfile(event, period_ns))
    return Following(event.vehicle, TraceProfile(event))
