"""The world: integrates the truth, lets vehicles sense it, and says what goes into the log."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.checks import flaw_of_command, flaw_of_links
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.packed import tag
from zenvoy.bus.topics import COMMAND, FRAMES, LINKS, POSITIONS, RADAR, SENSE, TRUTH, Topic
from zenvoy.laws import law_of
from zenvoy.scenarios import Scenario, modes, roster
from zenvoy.world.chronicle import Chronicle
from zenvoy.world.fleet import Fleet
from zenvoy.world.rows import command_row, estimate_row
from zenvoy.world.sensors import Readings, SensorSet

Floats = NDArray[np.float64]

_SENSE: Final = FlatEncoder(pb.Sense.DESCRIPTOR, leave_out=("wall_start_ns",))
_SENSE_OF_FIRST: Final = FlatEncoder(pb.Sense.DESCRIPTOR, leave_out=("ahead", "wall_start_ns"))
_WALL_START: Final = tag(pb.Sense.WALL_START_NS_FIELD_NUMBER, 1)
_FARTHEST: Final = 2  # cycles ahead; more overlaps nothing more and only fills queues


class WorldAgent:
    """Step k moves the truth to t_k and starts cycle k there, up to the end of the last cycle.

    For that it needs the commands that take effect before t_k, which with the delays of V2V are
    not those of cycle k - 1 but older ones: so it runs `lookahead` cycles ahead of the newest
    commands, and the cycles of world, channel and vehicles overlap. The steps after the end
    only log what is still to come. What vehicles wait for is sent first; the log is written
    while they work.
    """

    role = "world"
    name = "world"
    vehicles = ()

    def __init__(self, scenario: Scenario) -> None:
        self._period_ns, self._cycles = scenario.period_ns, scenario.cycles
        self._vehicles = range(1, scenario.fleet.size + 1)
        self._stops_on_collision = scenario.on_collision == "stop"
        self._fleet = Fleet(scenario)
        self._sensors = SensorSet(scenario.sensors, scenario.seed, scenario.fleet.size)
        self._chronicle = Chronicle(scenario)
        self._counts_neighbours = any(
            law_of(model).needs.sides for told in roster(scenario) for model in told.models
        )
        self._columns = {
            mode: len(law_of(model).columns)
            for model, mode in sorted(modes(scenario).items(), key=lambda one: one[1])
        }
        self._wait_ns, self._delay_ns = scenario.v2v_wait_ns, scenario.system_delay_ns
        delay_ns = self._wait_ns + self._delay_ns
        self._lookahead = min(delay_ns // scenario.period_ns, _FARTHEST)
        self._step = 0
        self.stopped = False
        self.wall_start_ns = 0  # in real time only: when time 0 is, on the wall clock

    @property
    def barrier(self) -> Barrier | None:
        """Commands and links of the newest cycle that the step depends on."""
        newest = self._step - 1 - self._lookahead
        if self.stopped or newest == self._cycles:
            return None
        now_ns = min(self._step, self._cycles) * self._period_ns
        if newest < 0:
            return Barrier(now_ns, 0)
        # Topics are awaited in this order, and a stall is blamed on the first that is missing.
        # So the single message comes before those of all vehicles.
        needs = ((LINKS, (0,)), (COMMAND, self._vehicles))
        return Barrier(now_ns, newest, needs)

    def flaw(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Commands and links are of their own cycle, and take effect when they are to."""
        start_ns = message.cycle * self._period_ns
        if topic is LINKS:
            return flaw_of_links(message, len(self._vehicles), start_ns)
        decided_ns = start_ns + self._wait_ns
        return flaw_of_command(message, vehicle, decided_ns, decided_ns + self._delay_ns)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Move the truth to `now_ns` and begin a cycle there; log what has become known."""
        cycle = self._step
        self._step += 1
        has_news = cycle > self._lookahead
        commands = inbox.all(COMMAND) if has_news else []
        past = self.past(commands, inbox.one(LINKS)) if has_news else []
        self.command(commands)
        return self.proceed(cycle, now_ns, commands, past)

    def command(self, commands: Sequence[pb.Command]) -> None:
        """Take in commands, to be applied when they take effect."""
        self._fleet.command(commands)

    def proceed(
        self, cycle: int, now_ns: int, commands: Sequence[pb.Command], past: list[Envelope]
    ) -> list[Envelope]:
        """Begin `cycle` at `now_ns`, or after the last one log what is left to be told.

        `commands` are those of the cycle that has ended, and `past` is the log's rows about it.
        """
        collided: list[int] = []
        if cycle > self._cycles:
            return past + self._chronicle.write(now_ns, commands, collided)
        collided = self._fleet.advance_to(now_ns)
        self.stopped = bool(collided) and self._stops_on_collision
        out, radar = self._begin(cycle, now_ns)
        out += past
        out.append(self._truth(cycle, now_ns))
        out += radar
        out += self._chronicle.write(now_ns, commands, collided)
        return out + ([self._chronicle.stop(now_ns, "collision")] if self.stopped else [])

    def _begin(self, cycle: int, now_ns: int) -> tuple[list[Envelope], list[Envelope]]:
        """What the others wait for to begin a cycle, and its row of the log; nothing at the end."""
        if self.stopped or cycle == self._cycles:
            return [], []
        position, speed = self._fleet.position, self._fleet.speed
        readings = self._sensors.read(cycle, self._fleet.road.gaps(position), position, speed)
        senses = self._senses(cycle, now_ns, readings)
        return [*senses, self._positions(cycle, now_ns)], [self._radar(cycle, now_ns, readings)]

    def _senses(self, cycle: int, now_ns: int, readings: Readings) -> list[Envelope]:
        """Each vehicle's own readings."""
        start_ns = self.wall_start_ns
        start = _WALL_START + start_ns.to_bytes(8, "little") if start_ns else b""
        rows = zip(
            self._vehicles,
            readings.gap.tolist(),
            readings.relative_speed.tolist(),
            readings.position.tolist(),
            readings.speed.tolist(),
            self._fleet.mean_acceleration.tolist(),
            strict=True,
        )
        senses = []
        for vehicle, gap, relative_speed, position, speed, acceleration in rows:
            own = {"position": position, "speed": speed, "acceleration": acceleration}
            if math.isnan(gap):  # nobody is ahead of the first vehicle of the open road
                sense = _SENSE_OF_FIRST.encode(cycle=cycle, time_ns=now_ns, vehicle=vehicle, **own)
            else:
                sense = _SENSE.encode(
                    cycle=cycle,
                    time_ns=now_ns,
                    vehicle=vehicle,
                    ahead_gap=gap,
                    ahead_speed=relative_speed,
                    **own,
                )
            senses.append(Envelope(SENSE, vehicle, sense + start))
        return senses

    def _positions(self, cycle: int, now_ns: int) -> Envelope:
        position = self._fleet.position.tolist()
        message = pb.Positions(
            cycle=cycle, time_ns=now_ns, position=position, wall_start_ns=self.wall_start_ns
        )
        return Envelope(POSITIONS, 0, message.SerializeToString())

    def past(self, commands: Sequence[pb.Command], links: pb.Links) -> list[Envelope]:
        """Rows of the log about the cycle that has ended."""
        return [
            Envelope(FRAMES, 0, links.frames, links.time_ns),
            estimate_row(commands, self._counts_neighbours, self._columns),
            command_row(commands),
        ]

    def _truth(self, cycle: int, now_ns: int) -> Envelope:
        message = pb.FleetTruth(
            cycle=cycle,
            time_ns=now_ns,
            position=self._fleet.position.tolist(),
            speed=self._fleet.speed.tolist(),
            acceleration=self._fleet.mean_acceleration.tolist(),
        )
        return Envelope(TRUTH, 0, message.SerializeToString(), now_ns)

    def _radar(self, cycle: int, now_ns: int, readings: Readings) -> Envelope:
        message = pb.FleetRadar(
            cycle=cycle,
            time_ns=now_ns,
            gap=readings.gap.tolist(),
            relative_speed=readings.relative_speed.tolist(),
            position=readings.position.tolist(),
            speed=readings.speed.tolist(),
            acceleration=self._fleet.mean_acceleration.tolist(),
        )
        return Envelope(RADAR, 0, message.SerializeToString(), now_ns)
