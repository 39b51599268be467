"""The world under either clock: it moves the vehicles, makes their readings and writes the log."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.checks import fault_in_command, table_of
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.frame_table import FrameTable
from zenvoy.bus.packed import tag
from zenvoy.bus.topics import FRAMES, POSITIONS, SENSE, vehicle_name
from zenvoy.laws import law_of
from zenvoy.scenarios import Scenario, attendance, modes, roster
from zenvoy.world.chronicle import Chronicle
from zenvoy.world.failing_processes import FailingProcesses, held
from zenvoy.world.fleet import Fleet
from zenvoy.world.rows import Decided, command_row, estimate_row, radar_row, truth_row
from zenvoy.world.sensor_faults import SensorFaults
from zenvoy.world.sensors import Readings, SensorSet

Floats = NDArray[np.float64]

_SENSE: Final = FlatEncoder(pb.Sense.DESCRIPTOR, leave_out=("wall_start_ns",))
_SENSE_OF_FIRST: Final = FlatEncoder(pb.Sense.DESCRIPTOR, leave_out=("ahead", "wall_start_ns"))
# A brake by hand is that of the paper.
_BY_HAND_NS: Final = 2_000_000_000
_BY_HAND_MPS2: Final = 3.0
_WALL_START: Final = tag(pb.Sense.WALL_START_NS_FIELD_NUMBER, 1)


class Begun(NamedTuple):
    """The results of beginning a cycle.

    messages: for vehicles and channel, which wait for them; empty from the end of the run on. rows:
    for the log. collided: indices of the vehicles that ran into the vehicle ahead.
    """

    messages: Sequence[Envelope] = ()
    rows: Sequence[Envelope] = ()
    collided: Sequence[int] = ()


class World:
    """The world of a scenario. `lock_step` and `realtime` decide when it does each of its steps.

    For each cycle it takes in the commands that have arrived, begins the cycle, and writes the
    events of the cycle. Once all commands and frames of an earlier cycle are in, it writes the rows
    of that cycle.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._period_ns, self._cycles = scenario.period_ns, scenario.cycles
        self._vehicles = range(1, scenario.fleet.size + 1)
        self._stops_on_collision = scenario.on_collision == "stop"
        self._fleet = Fleet(scenario)
        for one in held(scenario):
            self._fleet.let_roll(*one)
        self._processes = FailingProcesses(scenario)
        self._attendance = attendance(scenario)
        self._ends_on_loss = scenario.on_vehicle_loss == "abort"
        self._sensors = SensorSet(scenario.sensors, scenario.seed, scenario.fleet.size)
        self._sensor_faults = SensorFaults(scenario)
        self._chronicle = Chronicle(scenario)
        self._counts_neighbours = any(
            law_of(model).needs.sides for one in roster(scenario) for model in one.models
        )
        self._columns = {
            mode: len(law_of(model).columns)
            for model, mode in sorted(modes(scenario).items(), key=lambda one: one[1])
        }
        self._loss_by_hand = 0.0
        self._brakes_by = min(_BY_HAND_MPS2, scenario.control.acceleration_limit_mps2)
        self._wait_ns, self._delay_ns = scenario.v2v_wait_ns, scenario.system_delay_ns
        self.stopped = False
        """Whether a collision, or the loss of a vehicle, has ended the run."""
        self.lost = ""
        """The process whose loss has ended the run."""

    def fault_in_command(self, command: pb.Command, vehicle: int) -> str | None:
        """Return what is wrong with a command, or None.

        Its times must be those at which its cycle decides and takes effect.
        """
        decided_ns = self._decided_ns(command.cycle)
        return fault_in_command(command, vehicle, decided_ns, decided_ns + self._delay_ns)

    def table_of(self, links: pb.Links) -> FrameTable:
        """Return the table of frames in a message of the channel; raises RefusedError."""
        return table_of(links, len(self._vehicles), links.cycle * self._period_ns)

    def take_in(self, commands: Iterable[pb.Command]) -> None:
        """Keep commands until they take effect."""
        self._fleet.command(self._processes.taken_in(commands))

    def let_roll(self, vehicle: int, from_ns: int) -> None:
        """Let a vehicle roll without acceleration from an instant until its next command."""
        self._fleet.let_roll(vehicle, from_ns)

    def brake(self, vehicle: int, start_ns: int) -> None:
        """Let a vehicle brake by hand from an instant on, which is not before now."""
        span = (start_ns, start_ns + _BY_HAND_NS)
        self._fleet.brake(vehicle, *span, self._brakes_by)
        self._chronicle.brake(vehicle, span, self._brakes_by)

    def lose(self, share: float, start_ns: int) -> None:
        """Let a share of all frames be lost by hand from a cycle on, which is not before now."""
        self._loss_by_hand = share
        self._chronicle.lose(share, start_ns)

    def begin(self, cycle: int, wall_start_ns: int = 0) -> Begun:
        """Move the vehicles to the start of a cycle; after the end of the run, do nothing.

        wall_start_ns: in real time only, the wall time of time 0.
        """
        if cycle > self._cycles:
            return Begun()
        now_ns = cycle * self._period_ns
        collided = [index for _, index in self._fleet.advance_to(now_ns)]
        killed = self._attendance.killed_at(cycle) if self._ends_on_loss else []
        if killed:
            self.lost = vehicle_name(killed[0], len(self._vehicles))
        self.stopped = (bool(collided) and self._stops_on_collision) or bool(killed)
        fleet = self._fleet
        acceleration = fleet.mean_acceleration
        truth = truth_row(cycle, now_ns, fleet.position, fleet.speed, acceleration)
        if self.stopped or cycle == self._cycles:
            return Begun([], [truth], collided)
        readings = self._sensors.read(cycle, fleet.gaps, fleet.position, fleet.speed)
        readings, felt = self._sensor_faults.read(readings, acceleration, cycle, now_ns)
        radar = radar_row(cycle, now_ns, readings, felt)
        senses = self._senses(cycle, now_ns, readings, felt, wall_start_ns)
        messages = [*senses, self._positions(cycle, now_ns, wall_start_ns)]
        return Begun(messages, [truth, radar], collided)

    def events(
        self, cycle: int, commands: Iterable[pb.Command], collided: Sequence[int]
    ) -> list[Envelope]:
        """Return the events up to the start of a cycle, for the log.

        commands: those that arrived since the last call. collided: as `begin` returned it.
        """
        now_ns = min(cycle, self._cycles) * self._period_ns
        events = self._chronicle.write(now_ns, commands, collided)
        if self.stopped:
            why = f"{self.lost} killed" if self.lost else "collision"
            events.append(self._chronicle.stop(now_ns, why))
        return events

    def rows(self, cycle: int, frames: bytes, commands: Mapping[int, pb.Command]) -> list[Envelope]:
        """Return the rows of the log for a cycle that has ended.

        frames: its table, a serialized pb.Frames. commands: those that arrived, by vehicle.
        """
        decided = Decided(cycle, self._decided_ns(cycle), self._vehicles, commands)
        return [
            Envelope(FRAMES, 0, frames, cycle * self._period_ns),
            estimate_row(decided, self._counts_neighbours, self._columns),
            command_row(decided),
        ]

    def _decided_ns(self, cycle: int) -> int:
        return cycle * self._period_ns + self._wait_ns

    def _senses(
        self, cycle: int, now_ns: int, readings: Readings, felt: Floats, wall_start_ns: int
    ) -> list[Envelope]:
        """Return the readings of each vehicle; felt: those of its own acceleration, m/s²."""
        start = _WALL_START + wall_start_ns.to_bytes(8, "little") if wall_start_ns else b""
        rows = zip(
            self._vehicles,
            readings.gap.tolist(),
            readings.relative_speed.tolist(),
            readings.position.tolist(),
            readings.speed.tolist(),
            felt.tolist(),
            strict=True,
        )
        senses = []
        takes_part = self._attendance.takes_part
        for vehicle, gap, relative_speed, position, speed, acceleration in rows:
            if not takes_part(vehicle, cycle):
                continue
            own = {"position": position, "speed": speed, "acceleration": acceleration}
            if math.isnan(gap):  # the first vehicle of an open road has none ahead
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

    def _positions(self, cycle: int, now_ns: int, wall_start_ns: int) -> Envelope:
        position = self._fleet.position.tolist()
        message = pb.Positions(
            cycle=cycle,
            time_ns=now_ns,
            position=position,
            wall_start_ns=wall_start_ns,
            loss_by_hand=self._loss_by_hand,
        )
        return Envelope(POSITIONS, 0, message.SerializeToString())
