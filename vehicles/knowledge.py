"""What a vehicle knows: readings, what it heard, and the estimates made of both."""

from __future__ import annotations

from math import isfinite
from operator import attrgetter
from typing import Final

from google.protobuf.message import DecodeError

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.decision import View
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.gains import gain_schedule, settle
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.relative import Relative
from zenvoy.vehicles.state import LinkState, SpeedState

# A reading of the own acceleration that differs by more contradicts the commands, m/s².
_CONTRADICTS: Final = 0.1


class Knowledge:
    """Fed in order: `sense` at t_k, `hear` at t_k + v2v_wait, `command` when it is decided.

    `estimates`: whether to run the filters, which only PBCM needs.
    """

    def __init__(self, scenario: Scenario, ahead_id: int, behind_id: int, estimates: bool) -> None:
        self._ahead_id, self._behind_id = ahead_id, behind_id
        self._estimates = estimates
        self._period_ns = scenario.period_ns
        self._age_limit_ns = scenario.beacon_age_limit_ns
        keep_ns = scenario.beacon_age_limit_ns + scenario.system_delay_ns + 4 * scenario.period_ns
        self._own, self._ahead, self._behind = Motion(keep_ns), Motion(keep_ns), Motion(keep_ns)
        self._commanded = Motion(keep_ns)
        self._commanded.learn(0, 0, 0.0, (), ())
        self._sense = pb.Sense()
        self._heard_ahead_ns = -1
        self._heard_behind: pb.Beacon | None = None
        self._heard_behind_ns = -1
        self._set_up_estimates(scenario)

    def _set_up_estimates(self, scenario: Scenario) -> None:
        error_std, control = scenario.sensors.error_std, scenario.control

        def link(front: Motion, rear: Motion) -> LinkState:
            return LinkState(
                self._period_ns,
                scenario.estimator,
                gap_error=ReadingError(error_std, control.desired_gap_m),
                speed_error=ReadingError(error_std, control.desired_speed_mps),
                front=front,
                rear=rear,
            )

        self.link_ahead = link(front=self._ahead, rear=self._own)
        self.link_behind = link(front=self._own, rear=self._behind)
        own_error = ReadingError(error_std, control.desired_speed_mps)
        self.speed = SpeedState(self._period_ns, scenario.estimator, own_error)

    @property
    def age_ns(self) -> int:
        """Age at t_k of what the vehicle behind told; -1 where it told nothing yet."""
        if self._heard_behind is None:
            return -1
        return self._sense.time_ns - self._heard_behind_ns

    def sense(self, sense: pb.Sense) -> tuple[list[int], list[float]]:
        """Take in the own readings; returns the accelerations expected of oneself from t_k on.

        Times (ns) and values (m/s²): the commands, or the acceleration that was read where it
        contradicts them (a driver's foot on the brake, a vehicle that stands).
        """
        self._sense = sense
        start_ns, time_ns = sense.time_ns - self._period_ns, sense.time_ns
        reading = sense.acceleration
        if abs(reading - self._commanded.mean(start_ns, time_ns)) > _CONTRADICTS:
            plan = [time_ns], [reading]
        else:
            plan = self._commanded.steps_from(time_ns)
        self._own.learn(start_ns, time_ns, reading, *plan)
        return plan

    def hear(self, receive: pb.Receive) -> None:
        """Take in the frames that have arrived, then bring the estimates to t_k."""
        neighbours = (self._ahead_id, self._behind_id)
        payloads = receive.beacon
        beacons = [
            beacon
            for row, source in enumerate(receive.source)
            if source in neighbours and (beacon := self._understood(payloads[row]))
        ]
        for beacon in sorted(beacons, key=attrgetter("time_ns")):
            if beacon.vehicle == self._ahead_id and beacon.time_ns > self._heard_ahead_ns:
                self._heard_ahead_ns = beacon.time_ns
                self._learn(self._ahead, beacon)
            if beacon.vehicle == self._behind_id and beacon.time_ns > self._heard_behind_ns:
                self._heard_behind, self._heard_behind_ns = beacon, beacon.time_ns
                self._learn(self._behind, beacon)
                self._measure(self.link_behind, beacon)
        if self._sense.time_ns - self._heard_ahead_ns > self._age_limit_ns:
            self._ahead.forget()  # an old plan is worse than none
        self._measure(self.link_ahead, self._sense)
        if self._estimates:
            self.speed.measure(self._sense.speed, self._sense.acceleration)

    def _understood(self, payload: bytes) -> pb.Beacon | None:
        """Beacon in a frame; None where it makes no sense: anyone may send anything."""
        try:
            beacon = pb.Beacon.FromString(payload)
        except DecodeError:
            return None
        numbers = beacon.acceleration + beacon.speed + beacon.ahead.gap + beacon.ahead.speed
        plan = beacon.planned_acceleration
        makes_sense = (
            isfinite(numbers + sum(plan))
            and beacon.time_ns <= self._sense.time_ns
            and len(plan) == len(beacon.planned_from_ns)
        )
        return beacon if makes_sense else None

    def command(self, effective_ns: int, acceleration: float) -> None:
        """Remember a command on its way."""
        self._commanded.learn(effective_ns, effective_ns, acceleration, (), ())

    def read(self) -> View:
        """The newest readings, as they are."""
        sense, heard = self._sense, self._heard_behind
        return View(
            ahead=_relative(sense.ahead) if sense.HasField("ahead") else None,
            behind=_relative(heard.ahead) if heard and heard.HasField("ahead") else None,
            speed=sense.speed,
        )

    def predict(self, until_ns: int) -> View:
        """The estimates, predicted to `until_ns`. Needs `estimates`."""
        _, change = self._own.over(self._sense.time_ns, until_ns)
        return View(
            ahead=self.link_ahead.predict(until_ns),
            behind=self.link_behind.predict(until_ns),
            speed=max(0.0, self.speed.estimate + change),
        )

    def _learn(self, motion: Motion, beacon: pb.Beacon) -> None:
        time_ns = beacon.time_ns
        motion.learn(
            time_ns - self._period_ns,
            time_ns,
            beacon.acceleration,
            beacon.planned_from_ns,
            beacon.planned_acceleration,
        )

    def _measure(self, link: LinkState, source: pb.Beacon | pb.Sense) -> None:
        if self._estimates and source.HasField("ahead"):
            link.measure(source.time_ns, _relative(source.ahead), source.speed)


def prepare(scenario: Scenario) -> None:
    """Compute the gains of a steady flow, for the processes that are forked from this one."""
    if scenario.estimator.kind != "kalman":
        return  # nothing of the others is shared
    error_std, control = scenario.sensors.error_std, scenario.control
    gap = ReadingError(error_std, control.desired_gap_m).variance(control.desired_gap_m)
    speed = ReadingError(error_std, control.desired_speed_mps).variance(control.desired_speed_mps)
    for variances in ((gap, speed), (speed,)):
        period_s = scenario.period_ns * 1e-9
        settle(gain_schedule(period_s, scenario.estimator.acceleration_std_mps2, variances))


def _relative(link: pb.Link) -> Relative:
    return Relative(link.gap, link.speed)
