"""Filtered states of a link and of the own speed, each at the time of its newest reading."""

from __future__ import annotations

from typing import Final

from zenvoy.laws import Relative
from zenvoy.scenarios import Estimator
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.filters import state_filter
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.steps import NS, Number

# Missed periods after which a link starts anew instead of being predicted across the gap.
GIVE_UP_PERIODS: Final = 100


def predicted(
    p: Number, v: Number, dt: float, front: tuple[Number, Number], rear: tuple[Number, Number]
) -> Relative:
    """Return the state of a link dt (s) later; floats or arrays.

    front, rear: displacement beyond uniform motion (m) and change of speed (m/s) of its vehicles.
    """
    return Relative(p + v * dt + front[0] - rear[0], v + front[1] - rear[1])


class LinkState:
    """The filtered state of one link, at the time of its newest reading.

    `front` and `rear` are the motions of its two vehicles; the relative acceleration of the link is
    the difference of their accelerations. limit_s: the wall time that a step of a user's own
    estimator may take.
    """

    def __init__(
        self,
        period_ns: int,
        estimator: Estimator,
        *,
        gap_error: ReadingError,
        speed_error: ReadingError,
        front: Motion,
        rear: Motion,
        limit_s: float | None = None,
    ) -> None:
        self._period_ns = period_ns
        self._front, self._rear = front, rear
        self._filter = state_filter(estimator, period_ns, limit_s)
        self._gap_error, self._speed_error = gap_error, speed_error
        self.measured_ns = -1

    @property
    def estimate(self) -> Relative | None:
        """The state at `measured_ns`; None before the first reading."""
        return Relative(*self._filter.x) if self._filter.x else None

    @property
    def std(self) -> tuple[float, ...]:
        """The standard deviations of gap (m) and relative speed (m/s)."""
        return self._filter.std

    def measure(self, time_ns: int, reading: Relative, speed: float) -> None:
        """Take in a reading at `time_ns`; speed: the approximate speed of the vehicles, m/s."""
        periods = (time_ns - self.measured_ns) // self._period_ns
        if periods > GIVE_UP_PERIODS:
            self._filter.reset()
        started = self._filter.x
        inputs = self._relative_accelerations(time_ns, periods) if started else ()
        gap = started[0] if started else reading.p
        # The error of a relative speed is that of the absolute speed of the vehicle ahead.
        variances = (self._gap_error.variance(gap), self._speed_error.variance(speed))
        self._filter.step(inputs, reading, variances)
        self.measured_ns = time_ns

    def predict(self, until_ns: int) -> Relative | None:
        """Return the state at `until_ns`, from known and planned accelerations of both vehicles."""
        if not self._filter.x:
            return None
        p, v = self._filter.x
        front = self._front.over(self.measured_ns, until_ns)
        rear = self._rear.over(self.measured_ns, until_ns)
        return predicted(p, v, (until_ns - self.measured_ns) * NS, front, rear)

    def _relative_accelerations(self, time_ns: int, periods: int) -> list[float]:
        """Return the mean relative acceleration of each period up to `time_ns`, m/s²."""
        front, rear, period_ns = self._front.mean, self._rear.mean, self._period_ns
        if periods == 1:  # nearly always
            start_ns = time_ns - period_ns
            return [front(start_ns, time_ns) - rear(start_ns, time_ns)]
        return [
            front(start_ns, start_ns + period_ns) - rear(start_ns, start_ns + period_ns)
            for start_ns in range(time_ns - periods * period_ns, time_ns, period_ns)
        ]


class SpeedState:
    """The filtered own speed at the start of the cycle; `limit_s` as for a link."""

    def __init__(
        self,
        period_ns: int,
        estimator: Estimator,
        error: ReadingError,
        own: Motion,
        limit_s: float | None = None,
    ) -> None:
        self._period_ns = period_ns
        self._filter = state_filter(estimator, period_ns, limit_s)
        self._error = error
        self._own = own
        self._measured_ns = 0

    @property
    def estimate(self) -> float:
        """The own speed, m/s."""
        return self._filter.x[0]

    @property
    def std(self) -> float:
        """The standard deviation of the own speed, m/s."""
        return self._filter.std[0]

    def measure(self, time_ns: int, reading: float) -> None:
        """Take in a reading (m/s) at `time_ns`, with the known motion since the last one."""
        period_ns = self._period_ns
        if (time_ns - self._measured_ns) // period_ns > GIVE_UP_PERIODS:
            self._filter.reset()
        mean, started = self._own.mean, self._filter.x
        starts = range(self._measured_ns, time_ns, period_ns)
        inputs = [mean(start_ns, start_ns + period_ns) for start_ns in starts]
        about = started[0] if started else reading
        self._filter.step(inputs, (reading,), (self._error.variance(about),))
        self._measured_ns = time_ns
