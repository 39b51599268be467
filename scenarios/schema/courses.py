"""Values that a schedule changes over time, at once or in a linear ramp."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass

_NS_PER_S = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Course:
    """A piecewise linear value over time: `points` of (ns, value), the first at 0.

    If two points have the same time, the second counts from there on. After the last point the
    value stays constant.
    """

    points: tuple[tuple[int, float], ...]

    def at(self, time_ns: int) -> float:
        """Return the value at `time_ns`, which is not below 0."""
        (start_ns, start), end = self._around(time_ns)
        if end is None:
            return start
        end_ns, value = end
        return start + (value - start) * ((time_ns - start_ns) / (end_ns - start_ns))

    def rate(self, time_ns: int) -> float:
        """Return the rate of change from `time_ns` on, per second."""
        (start_ns, start), end = self._around(time_ns)
        if end is None:
            return 0.0
        return (end[1] - start) * _NS_PER_S / (end[0] - start_ns)

    def is_constant(self, from_ns: int, to_ns: int) -> bool:
        """Return whether the value is constant from `from_ns` to `to_ns`, both included."""
        within = (value for time_ns, value in self.points if from_ns < time_ns <= to_ns)
        value = self.at(from_ns)
        return self.at(to_ns) == value and all(other == value for other in within)

    def _around(self, time_ns: int) -> tuple[tuple[int, float], tuple[int, float] | None]:
        """Return the last point up to `time_ns`, and the next one."""
        index = bisect_right(self.points, time_ns, key=lambda point: point[0])
        following = self.points[index] if index < len(self.points) else None
        return self.points[index - 1], following


def course(start: float, changes: Iterable[tuple[int, int, float]]) -> Course:
    """Return the course of a value that begins at `start` and follows `changes` in order.

    After each change (at_ns, ramp_ns, value) it goes from its current value at at_ns linearly to
    the new value within ramp_ns.
    """
    points = [(0, start)]
    for at_ns, ramp_ns, value in changes:
        now = Course(tuple(points[-2:])).at(at_ns)
        while points[-1][0] > at_ns or points[-1][0] == at_ns > 0:
            points.pop()
        points += [(at_ns, now), (at_ns + ramp_ns, value)]
    return Course(tuple(points))


@dataclass(frozen=True, slots=True, kw_only=True)
class Targets:
    """Desired gap (m), desired speed (m/s) and gains (s⁻², s⁻¹, s⁻¹) of a vehicle over time.

    cruises_ns is the time from which the schedule gives it a desired speed; None: never.
    """

    desired_gap_m: Course
    desired_speed_mps: Course
    k_d: Course
    k_v: Course
    k_c: Course
    cruises_ns: int | None = None

    @property
    def change(self) -> bool:
        """Whether the schedule changes any of them."""
        courses = (self.desired_gap_m, self.desired_speed_mps, self.k_d, self.k_v, self.k_c)
        return any(len(course.points) > 1 for course in courses)
