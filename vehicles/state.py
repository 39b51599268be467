"""Filtered states of a link and of the own speed, on the readings' own times."""

from __future__ import annotations

from typing import Final

from zenvoy.laws import Relative
from zenvoy.scenarios import Estimator
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.filters import state_filter
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.steps import NS, Number

# Missed periods after which a link starts anew rather than be predicted through the gap.
GIVE_UP_PERIODS: Final = 100


def predicted(
    p: Number, v: Number, dt: float, front: tuple[Number, Number], rear: tuple[Number, Number]
) -> Relative:
    """Return a link's state dt (s) later: floats or arrays.

    front, rear: displacement beyond uniform motion (m) and change of speed (m/s) of its vehicles.
    """
    return Relative(p + v * dt + front[0] - rear[0], v + front[1] - rear[1])


class LinkState:
    """Filtered state of one link, at the time of its newest reading.

    `front` and `rear` are the motions of the two vehicles, the one ahead and the one behind; the
    link's relative acceleration is the difference of theirs. limit_s: wall time that a step of an
    estimator of the user's own may take.
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
        """State at `measured_ns`; None before the first reading."""
        return Relative(*self._filter.x) if self._filter.x else None

    @property
    def std(self) -> tuple[float, ...]:
        """Standard deviations of gap (m) and relative speed (m/s)."""
        return self._filter.std

    def measure(self, time_ns: int, reading: Relative, speed: float) -> None:
        """Take in a reading of `time_ns`; `speed` (m/s) is about that of the vehicles."""
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
        """State at `until_ns`, with the accelerations known and planned of both vehicles."""
        if not self._filter.x:
            return None
        p, v = self._filter.x
        front = self._front.over(self.measured_ns, until_ns)
        rear = self._rear.over(self.measured_ns, until_ns)
        return predicted(p, v, (until_ns - self.measured_ns) * NS, front, rear)

    def _relative_accelerations(self, time_ns: int, periods: int) -> list[float]:
        """Mean of each period up to `time_ns`, m/s²."""
        front, rear, period_ns = self._front.mean, self._rear.mean, self._period_ns
        if periods == 1:  # nearly always
            start_ns = time_ns - period_ns
            return [front(start_ns, time_ns) - rear(start_ns, time_ns)]
        return [
            front(start_ns, start_ns + period_ns) - rear(start_ns, start_ns + period_ns)
            for start_ns in range(time_ns - periods * period_ns, time_ns, period_ns)
        ]


class SpeedState:
    """Filtered own speed at the start of the cycle; `limit_s` as for a link."""

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
        """Own speed, m/s."""
        return self._filter.x[0]

    @property
    def std(self) -> float:
        """Its standard deviation, m/s."""
        return self._filter.std[0]

    def measure(self, time_ns: int, reading: float) -> None:
        """Take in a reading (m/s) of `time_ns`, with what is known of the motion in between."""
        period_ns = self._period_ns
        if (time_ns - self._measured_ns) // period_ns > GIVE_UP_PERIODS:
            self._filter.reset()
        mean, started = self._own.mean, self._filter.x
        starts = range(self._measured_ns, time_ns, period_ns)
        inputs = [mean(start_ns, start_ns + period_ns) for start_ns in starts]
        about = started[0] if started else reading
        self._filter.step(inputs, (reading,), (self._error.variance(about),))
        self._measured_ns = time_ns
