"""What the scenario does to vehicles whatever their controllers say."""

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
    """Rules the acceleration of a vehicle while it is in force."""

    @property
    def vehicle(self) -> int:
        """Number of the vehicle, from 1."""
        ...

    def changes(self, after_ns: int, before_ns: int) -> Iterator[int]:
        """Instants between the two at which the acceleration changes."""
        ...

    def in_force(self, time_ns: int) -> bool:
        """Whether it rules from `time_ns` on."""
        ...

    def acceleration(self, time_ns: int, speed: Floats) -> Floats | float | None:
        """What acts from `time_ns` on (m/s²) at that speed (m/s); None while not in force."""
        ...


@dataclass(frozen=True, slots=True)
class Braking:
    """A vehicle brakes at `deceleration` (m/s²) in [start_ns, end_ns)."""

    vehicle: int
    start_ns: int
    end_ns: int
    deceleration: float

    def changes(self, after_ns: int, before_ns: int) -> Iterator[int]:
        """Its start and its end, where they lie between the two."""
        return (t for t in (self.start_ns, self.end_ns) if after_ns < t < before_ns)

    def in_force(self, time_ns: int) -> bool:
        """Whether it brakes."""
        return self.start_ns <= time_ns < self.end_ns

    def acceleration(self, time_ns: int, speed: Floats) -> float | None:
        """The deceleration (m/s²), while it brakes."""
        return -self.deceleration if self.in_force(time_ns) else None


class Returning:
    """A vehicle goes back from a brake to the speed that it had when the brake began."""

    def __init__(self, brake: Brake) -> None:
        self.vehicle = brake.vehicle
        self._brakes_ns, self._start_ns, self._end_ns = (
            brake.start_ns,
            brake.end_ns,
            brake.returned_ns,
        )
        self._before: Floats | None = None

    def changes(self, after_ns: int, before_ns: int) -> Iterator[int]:
        """Start and end of the brake, and its own end, where they lie between the two."""
        times = (self._brakes_ns, self._start_ns, self._end_ns)
        return (t for t in times if after_ns < t < before_ns)

    def in_force(self, time_ns: int) -> bool:
        """Whether it goes back."""
        return self._start_ns <= time_ns < self._end_ns

    def acceleration(self, time_ns: int, speed: Floats) -> Floats | None:
        """What takes it there evenly (m/s²), while it goes back.

        The fleet asks at every change, and so at the start of the brake, when it learns the speed.
        """
        if self._before is None and time_ns >= self._brakes_ns:
            self._before = speed.copy()
        if self._before is None or not self.in_force(time_ns):
            return None
        return np.asarray((self._before - speed) / ((self._end_ns - time_ns) * 1e-9))


class Overrides:
    """All events of a scenario.

    Brakes come before speeds to follow, the hardest brake first, and returns from brakes last.
    """

    def __init__(self, scenario: Scenario) -> None:
        brakes = sorted(scenario.brakes, key=lambda brake: brake.deceleration_mps2)
        # The later in the list, the stronger.
        self._all: list[Override] = [
            *(Returning(brake) for brake in brakes if brake.return_s is not None),
            *(_following(event, scenario.period_ns) for event in scenario.profiles),
            *(_braking(brake) for brake in brakes),
        ]

    def changes(self, after_ns: int, before_ns: int) -> set[int]:
        """Instants between the two at which an acceleration changes."""
        return {t for override in self._all for t in override.changes(after_ns, before_ns)}

    def ruled(self, time_ns: int) -> list[int]:
        """Indices of the vehicles whose acceleration events rule from `time_ns` on."""
        return [override.vehicle - 1 for override in self._all if override.in_force(time_ns)]

    def applied(self, time_ns: int, a: Floats, speed: Floats) -> Floats:
        """Accelerations (…, n) from `time_ns` on: `a` where nothing overrides it, at `speed`."""
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
