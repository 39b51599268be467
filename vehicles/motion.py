"""The known and expected acceleration of a vehicle, as a step function of time."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from zenvoy.vehicles.steps import NS, over, spans, steady


class Motion:
    """Acceleration (m/s²) over time (ns): readings for the past, plans for the future.

    It is constant between steps. Before the first step it has the first value, and after the last
    step the last one. If nothing is known, it is 0.
    """

    __slots__ = ("_from_ns", "_keep_ns", "_read_from_ns", "_read_to_ns", "_reading", "_value")

    def __init__(self, keep_ns: int) -> None:
        self._keep_ns = keep_ns
        self._from_ns: list[int] = []
        self._value: list[float] = []
        self._read_from_ns = self._read_to_ns = 0
        self._reading = 0.0

    def learn(
        self,
        start_ns: int,
        end_ns: int,
        reading: float,
        plan_from_ns: Sequence[int],
        plan: Sequence[float],
    ) -> None:
        """Take in a mean that was read over [start, end], and a plan from end_ns on.

        The first entry of the plan is in force at end_ns. Everything after start_ns that was known
        before is forgotten, so readings must arrive in order of time.
        """
        times, values = self._from_ns, self._value
        known = len(times)
        while known and times[known - 1] >= start_ns:
            known -= 1
        del times[known:], values[known:]
        times.append(start_ns)
        values.append(reading)
        for from_ns in plan_from_ns:
            times.append(from_ns if from_ns > end_ns else end_ns)
        values += plan
        oldest_ns = end_ns - self._keep_ns
        while len(times) > 1 and times[1] < oldest_ns:
            del times[0], values[0]
        self._read_from_ns, self._read_to_ns, self._reading = start_ns, end_ns, reading

    def forget(self) -> None:
        """Forget everything."""
        self._from_ns.clear()
        self._value.clear()
        self._read_from_ns = self._read_to_ns = 0

    def mean(self, t0_ns: int, t1_ns: int) -> float:
        """Return the mean acceleration from t0 to t1, m/s²."""
        if t0_ns == self._read_from_ns and t1_ns == self._read_to_ns:
            return self._reading
        return self.over(t0_ns, t1_ns)[1] / ((t1_ns - t0_ns) * NS)

    def over(self, t0_ns: int, t1_ns: int) -> tuple[float, float]:
        """Return displacement beyond uniform motion (m) and change of speed (m/s), t0 to t1."""
        times, values = self._from_ns, self._value
        if not times:
            return 0.0, 0.0
        if t0_ns >= times[-1]:  # nearly always: nothing changes after t0
            return steady(values[-1], (t1_ns - t0_ns) * NS)
        return over(spans(times, t0_ns, t1_ns), values)

    def steps_from(self, time_ns: int) -> tuple[list[int], list[float]]:
        """Return times and values of the step in force at `time_ns` and of all later steps."""
        times, values = self._from_ns, self._value
        if not times:
            return [time_ns], [0.0]
        at = max(bisect_right(times, time_ns) - 1, 0)
        return [time_ns, *times[at + 1 :]], values[at:]
