"""What a vehicle knows of another one's odometer: its newest beacon, and uniform motion after."""

from __future__ import annotations

from zenvoy.vehicles.odometer import Odometer, coasted, moved
from zenvoy.vehicles.received import ReceivedBeacon, Report
from zenvoy.vehicles.steps import NS, over, spans


class Reckoned:
    """The odometer of another vehicle over time, from a beacon.

    It moves as planned until the first command that the beacon cannot contain takes effect, at
    `until_ns`, and uniformly from then on. A command that takes effect later than this replaces a
    plan, so to hold its last value would be wrong for longer and longer.
    """

    __slots__ = ("_at", "_from_ns", "_plan", "_until", "since_ns", "time_ns", "until_ns")

    def __init__(self, beacon: ReceivedBeacon, report: Report, effect_ns: int) -> None:
        """`report`: that of the beacon. effect_ns: from a cycle to the effect of its command."""
        self.time_ns, self.since_ns = beacon.time_ns, report.since_ns
        self._at = report.odometer
        self._from_ns = [max(one, self.time_ns) for one in beacon.planned_from_ns] or [self.time_ns]
        self._plan = beacon.planned_acceleration or (0.0,)
        self.until_ns = max(self.time_ns + effect_ns, self._from_ns[-1])
        self._until = self._moved(self.until_ns)

    def at(self, time_ns: int) -> Odometer:
        """Return the odometer at a time, not before the beacon's."""
        if time_ns >= self.until_ns:
            return coasted(self._until, (time_ns - self.until_ns) * NS)
        return self._at if time_ns == self.time_ns else self._moved(time_ns)

    def _moved(self, time_ns: int) -> Odometer:
        by = over(spans(self._from_ns, self.time_ns, time_ns), self._plan)
        return moved(self._at, (time_ns - self.time_ns) * NS, by)
