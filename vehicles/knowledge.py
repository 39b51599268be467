"""What a vehicle knows: its readings, the beacons of others, and estimates from both.

A reading or a beacon changes motions, filters and shared estimates at once, in an order that
decides the bits of a run. So all of them are one object in one module, although it is long.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion as LawMotion
from zenvoy.laws import Relative
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.commanded import commanded
from zenvoy.vehicles.decision import Predicted, View
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.link_errors import link_errors
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.neighbours import Neighbours
from zenvoy.vehicles.radio import Radio
from zenvoy.vehicles.received import ReceivedBeacon, Report, radar_in
from zenvoy.vehicles.shared_links import LinkEstimate, SharedLinks
from zenvoy.vehicles.state import LinkState, SpeedState

# A reading of the own acceleration that differs by more contradicts the commands, m/s².
CONTRADICTS: Final = 0.1


class Knowledge:
    """The knowledge of a vehicle.

    In each cycle call `sense` at t_k, `take_in` at t_k + v2v_wait, then `command` with the
    decision. `estimates`: whether to run the filters, which only laws with prediction need. lag_s:
    time constant of the vehicle's actuator, s; 0: none. shares: whether
    to report what laws that share links need. acts_on_shared: whether the vehicle acts on shared
    estimates itself.
    """

    def __init__(
        self,
        scenario: Scenario,
        neighbours: Neighbours,
        estimates: bool,
        lag_s: float = 0.0,
        *,
        shares: bool = False,
        acts_on_shared: bool = False,
    ) -> None:
        self._neighbours = neighbours
        self._ahead_id = neighbours.ahead[0] if neighbours.ahead else 0
        self._behind_id = neighbours.behind[0] if neighbours.behind else 0
        self._estimates = estimates
        self._by_position = scenario.control.neighbour_state == "position"
        self._period_ns = scenario.period_ns
        self._keep_ns = (
            scenario.beacon_age_limit_ns + scenario.system_delay_ns + 4 * scenario.period_ns
        )
        self._own, self._ahead, self._behind = (Motion(self._keep_ns) for _ in range(3))
        self._commanded = commanded(lag_s, self._keep_ns)
        self.radio = Radio(neighbours, scenario.beacon_age_limit_ns)
        self._sense = pb.Sense()
        self.radar: Relative | None = None
        self._past: dict[int, pb.Sense] = {}  # own readings by time, to compare positions with
        self._length_m = scenario.fleet.length_m
        self.newest_command = 0.0
        """The newest command, or the reading where it contradicts the commands, m/s²."""
        self._set_up_estimates(scenario)
        self._shared: SharedLinks | None = None
        self._acts_on_shared = acts_on_shared
        if shares:
            self._shared = SharedLinks(scenario, self._own)
        self.report: Report | None = None
        """What the beacon of the cycle says for laws that share links."""

    def _set_up_estimates(self, scenario: Scenario) -> None:
        gap_error, speed_error = link_errors(scenario)

        limit_s = scenario.stall_limit_s

        def link(front: Motion, rear: Motion) -> LinkState:
            return LinkState(
                self._period_ns,
                scenario.estimator,
                gap_error=copy(gap_error),
                speed_error=copy(speed_error),
                front=front,
                rear=rear,
                limit_s=limit_s,
            )

        self.link_ahead = link(front=self._ahead, rear=self._own)
        self.link_behind = link(front=self._own, rear=self._behind)
        speed = scenario.control.desired_speed_mps
        own_error = ReadingError(scenario.sensors.error_std, speed)
        self.speed = SpeedState(self._period_ns, scenario.estimator, own_error, self._own, limit_s)

    @property
    def age_ns(self) -> int:
        """The age at t_k of the newest beacon of the vehicle behind, ns; -1 if there is none."""
        return self.radio.age_ns(self._behind_id)

    def sense(self, sense: pb.Sense) -> tuple[list[int], list[float]]:
        """Take in the own readings, and return the accelerations expected from t_k on.

        These are times (ns) and values (m/s²): the commands, or the acceleration that was read if
        it contradicts them (a driver brakes, or the vehicle stands).
        """
        self._sense, self.radar = sense, radar_in(sense)
        time_ns = sense.time_ns
        start_ns = time_ns - self._period_ns
        if self._by_position:
            self._past[time_ns] = sense
            if len(self._past) > self._keep_ns // self._period_ns + 2:
                del self._past[next(iter(self._past))]
        reading = sense.acceleration
        if abs(reading - self._commanded.mean(start_ns, time_ns)) > CONTRADICTS:
            plan = [time_ns], [reading]
            self.newest_command = reading
            self._commanded.restart(time_ns, reading)
        else:
            plan = self._commanded.steps_from(time_ns)
        self._own.learn(start_ns, time_ns, reading, *plan)
        if self._shared is not None:
            self.report = self._shared.sense(time_ns, self.radar, sense.speed)
        return plan

    def take_in(self, received: Sequence[pb.Receive]) -> None:
        """Take in the frames that have arrived, then update the estimates to t_k."""
        sense = self._sense
        time_ns, speed = sense.time_ns, sense.speed
        for beacon in self.radio.take_in(received, time_ns):
            self._share(beacon)
            if beacon.vehicle == self._ahead_id:
                self._learn(self._ahead, beacon)
                if self._by_position:
                    state = self._gap_then(beacon, ahead=True)
                    self._measure(self.link_ahead, beacon.time_ns, state, beacon.speed)
            if beacon.vehicle == self._behind_id:
                self._learn(self._behind, beacon)
                state = self._gap_then(beacon, ahead=False) if self._by_position else beacon.radar
                self._measure(self.link_behind, beacon.time_ns, state, beacon.speed)
        if self.radio.fresh(self._ahead_id) is None:
            self._ahead.forget()  # an old plan is worse than none
        if not self._by_position:
            self._measure(self.link_ahead, time_ns, self.radar, speed)
        if self._estimates:
            self.speed.measure(time_ns, speed)

    def command(self, effective_ns: int, acceleration: float) -> None:
        """Remember a command that takes effect later."""
        self._commanded.command(effective_ns, acceleration)
        self.newest_command = acceleration

    def read(self, now_ns: int) -> View:
        """Return the newest readings; those older than the age limit are missing."""
        radar = self.radar
        if self._by_position:
            ahead, behind = self._positions(now_ns)
            link_ahead, link_behind = next(iter(ahead), None), next(iter(behind), None)
        else:
            link_ahead, link_behind = radar, self.radio.radar_of(self._behind_id)
        sense = self._sense
        return View(
            radar,
            link_ahead,
            link_behind,
            sense.speed,
            acceleration=sense.acceleration,
            length_m=self._length_m,
            behind_age_s=NAN if self._shared is None else self._shared.behind_age_s,
        )

    def motion_of(
        self, other: int, seam_m: float, steps: int, *, commands: bool
    ) -> LawMotion | None:
        """Return what the `steps`-th vehicle ahead reports; None where it is missing or too old.

        seam_m is added to the difference of positions, m. commands: whether its command is needed.
        """
        here = self._sense.position - seam_m
        return self.radio.motion_of(other, here, steps, commands=commands)

    def sides(self, now_ns: int) -> tuple[tuple[Relative, Relative], ...]:
        """Return the states to the j-th vehicle ahead and behind, as far as both are known."""
        if self._by_position:
            ahead, behind = self._positions(now_ns)
        else:
            ahead, behind = self.radio.chains(self.radar)
        return tuple(zip(ahead, behind, strict=False))

    def predict(self, until_ns: int) -> Predicted:
        """Return the estimates, predicted to `until_ns`; only with `estimates`."""
        _, change = self._own.over(self._sense.time_ns, until_ns)
        speed = max(0.0, self.speed.estimate + change)
        if self._shared is not None and self._acts_on_shared:
            return Predicted(*self._shared.predict(until_ns), speed)
        ahead, behind = self.link_ahead.predict(until_ns), self.link_behind.predict(until_ns)
        return Predicted(ahead, behind, speed)

    @property
    def links(self) -> tuple[LinkEstimate, LinkEstimate]:
        """The estimates of the links ahead and behind that the vehicle acts on."""
        if self._shared is not None and self._acts_on_shared:
            return self._shared.ahead, self._shared.behind
        ahead, behind = (
            LinkEstimate(link.estimate, link.std, link.measured_ns)
            for link in (self.link_ahead, self.link_behind)
        )
        return ahead, behind

    def _share(self, beacon: ReceivedBeacon) -> None:
        """Take in what a beacon says for laws that share links."""
        if self._shared is None:
            return
        if beacon.vehicle == self._ahead_id:
            self._shared.hear_ahead(beacon)
        if beacon.vehicle == self._behind_id:
            self._shared.hear_behind(beacon)

    def _positions(self, now_ns: int) -> tuple[list[Relative], list[Relative]]:
        """Return states from the own position now and the last reported ones, as if these were new.

        The lists have the vehicles ahead and behind.
        """
        sense = self._sense
        here = sense.position + sense.speed * (now_ns - sense.time_ns) * 1e-9
        return self.radio.positions(here, sense.speed)

    def _gap_then(self, beacon: ReceivedBeacon, *, ahead: bool) -> Relative | None:
        """Return the state of a link at the time of a beacon, from both positions at that time."""
        own = self._past.get(beacon.time_ns)
        if own is None:
            return None
        if ahead:
            gap = beacon.position + self._neighbours.seam_ahead[0] - own.position
            return Relative(gap, beacon.speed - own.speed)
        gap = own.position - beacon.position + self._neighbours.seam_behind[0]
        return Relative(gap, own.speed - beacon.speed)

    def _learn(self, motion: Motion, beacon: ReceivedBeacon) -> None:
        time_ns = beacon.time_ns
        motion.learn(
            time_ns - self._period_ns,
            time_ns,
            beacon.acceleration,
            beacon.planned_from_ns,
            beacon.planned_acceleration,
        )

    def _measure(self, link: LinkState, time_ns: int, state: Relative | None, speed: float) -> None:
        if self._estimates and not self._acts_on_shared and state is not None:
            link.measure(time_ns, state, speed)
