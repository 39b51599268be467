"""The world under either clock: it moves the vehicles, makes their readings and writes the log."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.bundles import Parcel
from zenvoy.bus.checks import are_modes, fault_in_command, table_of
from zenvoy.bus.frame_table import FrameTable
from zenvoy.bus.topics import FRAMES, POSITIONS, vehicle_name
from zenvoy.laws import law_of
from zenvoy.scenarios import Scenario, attendance, modes, roster
from zenvoy.world.chronicle import Chronicle
from zenvoy.world.commands import CommandReader, Commands, FleetCommands, Rows
from zenvoy.world.failing_processes import FailingProcesses, held
from zenvoy.world.fallbacks import Fallbacks, fallback_event
from zenvoy.world.fleet import Fleet
from zenvoy.world.rows import Decided, command_row, estimate_row, radar_row, truth_row
from zenvoy.world.senses import senses
from zenvoy.world.sensor_faults import SensorFaults
from zenvoy.world.sensors import SensorSet

# A brake by hand is that of the paper.
_BY_HAND_NS: Final = 2_000_000_000
_BY_HAND_MPS2: Final = 3.0


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
        self._values = max(self._columns.values(), default=0)
        self.command_reader: Final = CommandReader(self._values)
        """Reads the commands of the vehicles."""
        self._fallbacks = Fallbacks(scenario.fleet.size)
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

    def decode_jointly(self, parcels: Sequence[Parcel]) -> Commands | None:
        """Return the commands of the vehicles of a shared process; None if any is in doubt.

        They have passed all checks of `fault_in_command`, and each vehicle takes part.
        """
        vehicles, payloads = zip(*parcels, strict=True)
        commands = self.command_reader.flat(payloads)
        if commands is None or not self._are_sound(commands, vehicles):
            return None
        takes_part = self._attendance.takes_part
        all_take_part = all(takes_part(vehicle, commands.cycle) for vehicle in vehicles)
        return commands if all_take_part else None

    def _are_sound(self, commands: Commands, vehicles: Sequence[int]) -> bool:
        """Return whether commands are those of these vehicles, of one cycle, without a fault."""
        rows = commands.rows
        decided_ns = self._decided_ns(commands.cycle)
        return bool(
            np.array_equal(rows["vehicle"], vehicles)
            and (rows["cycle"] == commands.cycle).all()
            and (rows["time_ns"] == decided_ns).all()
            and (rows["effective_ns"] == decided_ns + self._delay_ns).all()
            and np.isfinite(rows["acceleration"]).all()
            and are_modes(rows["mode"])
        )

    def table_of(self, links: pb.Links) -> FrameTable:
        """Return the table of frames in a message of the channel; raises RefusedError."""
        return table_of(links, len(self._vehicles), links.cycle * self._period_ns)

    def take_in(self, rows: Rows) -> None:
        """Keep commands until they take effect; rows: of `ROW`, changed if processes are slow."""
        effective = self._processes.taken_in(rows)
        self._fleet.command(
            effective["vehicle"], effective["effective_ns"], effective["acceleration"]
        )

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
        there = self._attendance.there(cycle)
        of_vehicles = senses(cycle, now_ns, there, readings, felt, wall_start_ns)
        messages = [*of_vehicles, self._positions(cycle, now_ns, wall_start_ns)]
        return Begun(messages, [truth, radar], collided)

    def no_commands(self) -> FleetCommands:
        """Return the commands of a cycle of which none has arrived."""
        return FleetCommands(len(self._vehicles), self._values)

    def events(
        self, cycle: int, commands: FleetCommands | None, collided: Sequence[int]
    ) -> list[Envelope]:
        """Return the events up to the start of a cycle, for the log.

        commands: those of the newest cycle that has ended. collided: as `begin` returned it.
        """
        now_ns = min(cycle, self._cycles) * self._period_ns
        fallbacks = [] if commands is None else self._fallbacks_in(commands)
        events = self._chronicle.write(now_ns, fallbacks, collided)
        if self.stopped:
            why = f"{self.lost} killed" if self.lost else "collision"
            events.append(self._chronicle.stop(now_ns, why))
        return events

    def _fallbacks_in(self, commands: FleetCommands) -> list[pb.Event]:
        there, rows = np.flatnonzero(commands.there), commands.rows
        return [
            fallback_event(index + 1, begins, int(rows["time_ns"][index]))
            for index, begins in self._fallbacks.take_in(there, rows["mode"][there])
        ]

    def rows(self, cycle: int, frames: bytes, commands: FleetCommands) -> list[Envelope]:
        """Return the rows of the log for a cycle that has ended.

        frames: its table, a serialized pb.Frames. commands: those that arrived.
        """
        decided = Decided(cycle, self._decided_ns(cycle), commands)
        return [
            Envelope(FRAMES, 0, frames, cycle * self._period_ns),
            estimate_row(decided, self._counts_neighbours, self._columns),
            command_row(decided),
        ]

    def _decided_ns(self, cycle: int) -> int:
        return cycle * self._period_ns + self._wait_ns

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
