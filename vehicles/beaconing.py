"""Rules that decide when a vehicle sends a beacon."""

from __future__ import annotations

from typing import Final, Protocol

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.state import SpeedState

# ETSI EN 302 637-2 V1.4.1, 6.1.3. Vehicles drive along a line, so their heading never changes.
_MOVED_M: Final = 4.0
_FASTER_MPS: Final = 0.5
_LEAST_NS: Final = 100_000_000  # T_GenCamMin
_MOST_NS: Final = 1_000_000_000  # T_GenCamMax
_REPEATS: Final = 3  # N_GenCam


class Beaconing(Protocol):
    """A beacon rule, which is asked once in each cycle."""

    def next(self, sense: pb.Sense) -> int | None:
        """Return the sequence number of the beacon of this cycle, or None if none is sent."""


class EveryNth:
    """A beacon in every n-th cycle, from cycle `first` on."""

    def __init__(self, n: int, first: int) -> None:
        self._n, self._first = n, first

    def next(self, sense: pb.Sense) -> int | None:
        """Return the number of the beacon, from 0, or None if none is sent."""
        number, rest = divmod(sense.cycle - self._first, self._n)
        return number if rest == 0 and number >= 0 else None


class EtsiCam:
    """The triggers of the cooperative awareness service, from the vehicle's own readings.

    A message is due when position or speed has changed by more than a threshold since the last one,
    or when the last one is T_GenCam old. After a change has triggered a message, T_GenCam is the
    time since the message before, for three messages; then it is 1 s again. Messages are at least
    100 ms apart. The speed is filtered as in the vehicle's own estimator, because errors of
    readings would trigger messages.
    """

    def __init__(self, speed: SpeedState, own: Motion, period_ns: int) -> None:
        """Take the filter of the own speed, and the motion from which it gets its inputs."""
        self._speed_state, self._own, self._period_ns = speed, own, period_ns
        self._sent_ns = -1
        self._position = self._speed = 0.0
        self._interval_ns, self._repeats, self._number = _MOST_NS, 0, 0

    def next(self, sense: pb.Sense) -> int | None:
        """Return the number of the beacon, or None if none is sent.

        Numbers count up from the cycle of the first beacon: from 0, or from a higher number in a
        vehicle that replaces another one, whose numbers must not repeat.
        """
        start_ns = sense.time_ns - self._period_ns
        self._own.learn(start_ns, sense.time_ns, sense.acceleration, (), ())
        self._speed_state.measure(sense.time_ns, sense.speed)
        speed = self._speed_state.estimate
        if self._sent_ns >= 0 and not self._due(sense, speed):
            return None
        if self._sent_ns < 0:
            self._number = sense.cycle
        self._sent_ns, self._position, self._speed = sense.time_ns, sense.position, speed
        self._number += 1
        return self._number - 1

    def _due(self, sense: pb.Sense, speed: float) -> bool:
        since_ns = sense.time_ns - self._sent_ns
        if since_ns < _LEAST_NS:
            return False
        moved = abs(sense.position - self._position) > _MOVED_M
        if moved or abs(speed - self._speed) > _FASTER_MPS:
            self._interval_ns, self._repeats = min(since_ns, _MOST_NS), 0
            return True
        if since_ns < self._interval_ns:
            return False
        self._repeats += 1
        if self._repeats >= _REPEATS:
            self._interval_ns = _MOST_NS
        return True


def beaconing(scenario: Scenario, vehicle: int) -> Beaconing:
    """Return the rule of a scenario for a vehicle."""
    if scenario.beacons.rule == "etsi-cam":
        own = Motion(_MOST_NS)
        error = ReadingError(scenario.sensors.error_std, scenario.control.desired_speed_mps)
        speed = SpeedState(scenario.period_ns, scenario.estimator, error, own)
        return EtsiCam(speed, own, scenario.period_ns)
    return EveryNth(scenario.cycles_per_beacon, first_beacon(scenario, vehicle))


def first_beacon(scenario: Scenario, vehicle: int) -> int:
    """Return the cycle of the first beacon of a vehicle: (i - 1) mod n in turn, 0 otherwise."""
    return (vehicle - 1) % scenario.cycles_per_beacon if scenario.beacons_in_turn else 0
