"""The world in real time: it begins each cycle on time, with the commands that have arrived."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope, JointDecoder
from zenvoy.bus.bundles import Parcel
from zenvoy.bus.checks import fault_in_timing
from zenvoy.bus.frame_table import FrameTable
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.refusals import FOREIGN, STALE, UNCLOCKED
from zenvoy.bus.topics import COMMAND, EVENTS, LINKS, Topic
from zenvoy.scenarios import Scenario, attendance
from zenvoy.world.agent import World
from zenvoy.world.commands import Commands
from zenvoy.world.link_tables import LinkTables
from zenvoy.world.realtime_commands import Arrived, CycleCommands, RealtimeCommands
from zenvoy.world.realtime_rows import frames_of, realtime_row
from zenvoy.world.silent_vehicles import SilentVehicles
from zenvoy.world.timings import Timings, are_timings

_OVERRUN_NS: Final = 1_000_000  # of wall time; a cycle that begins later than this has overrun


@dataclass(frozen=True, slots=True, kw_only=True)
class _EndedCycle:
    """All messages about a cycle that has ended.

    receivers: the commands that should use its frames, of this cycle or the next.
    """

    cycle: int
    began_ns: int
    tables: list[FrameTable]
    commands: CycleCommands
    receivers: Sequence[Arrived]


class RealtimeWorld:
    """Begins cycle k at t_k, whether or not commands are missing, and logs cycles that have ended.

    A command takes effect at its time, or on arrival if that is later. A vehicle that sends no
    command keeps its last acceleration for as long as beacons count (`beacon_age_limit_ms`), then
    rolls.

    A cycle is logged `lag` cycles later. By then its commands have taken effect, its frames have
    been delivered, and the receivers have reported which frames were late. It is logged after three
    quarters of that later cycle, when no other process waits for the world:

        t_k                                t_(k+lag)           + 3/4 T
        begin k, send senses, positions    begin k + lag       log k
    """

    role = "world"
    name = "world"
    vehicles = ()
    sends_together = False
    may_wait: frozenset[Topic[Any]] = frozenset()

    def __init__(self, scenario: Scenario) -> None:
        self._core = World(scenario)
        self._vehicles = range(1, scenario.fleet.size + 1)
        self._period_ns, self._cycles = scenario.period_ns, scenario.cycles
        self._effect_ns = scenario.v2v_wait_ns + scenario.system_delay_ns
        self._most_error_ns = scenario.max_clock_error_ns
        self._attendance = attendance(scenario)
        self._overrun_ns = round(_OVERRUN_NS * scenario.speed)
        # Frames count in the decision of their own cycle, or of the next one (docs/decisions.md).
        self._decided_later = 0 if scenario.v2v_wait_ns else 1
        self._log_after_ns = 3 * self._period_ns // 4
        self._lag = 1 + self._decided_later + -(-self._effect_ns // self._period_ns)
        self._wall_start_ns = 0
        self._cycle = 0  # the next to begin
        self._silent = SilentVehicles(scenario)
        self._commands = RealtimeCommands(
            len(self._vehicles), self._core.command_reader, self._core.no_commands
        )
        self._events: list[pb.Event] = []  # logged when the next cycle begins
        # Messages about the cycles that are not logged yet, by cycle.
        self._began_ns: dict[int, int] = {}
        self._tables = LinkTables(self._core.table_of)
        self._ended: _EndedCycle | None = None  # the next cycle to be logged
        self._linked_ns = 0  # when the channel last sent a table
        self._commanded_ns = 0  # when a vehicle last sent a command
        self.overruns = 0
        self.joint_decoders: Mapping[Topic[Any], JointDecoder] = {COMMAND: self._decode_jointly}

    @property
    def channel_silent_ns(self) -> int:
        """For how long vehicles have sent commands, and so beacons, but the channel no table."""
        return self._commanded_ns - self._linked_ns

    @property
    def lost(self) -> str:
        """The process whose loss has ended the run."""
        return self._core.lost

    def start(self, wall_start_ns: int) -> None:
        """Set the wall time of time 0, which the world tells vehicles and channel."""
        self._wall_start_ns = wall_start_ns

    def brake(self, vehicle: int) -> None:
        """Let a vehicle brake by hand from the next cycle on."""
        if vehicle in self._vehicles and self._cycle < self._cycles:
            self._core.brake(vehicle, self._cycle * self._period_ns)

    def lose(self, share: float) -> None:
        """Let a share of all frames be lost by hand from the next cycle on."""
        if self._cycle < self._cycles:
            self._core.lose(share, self._cycle * self._period_ns)

    @property
    def due_ns(self) -> int:
        """When to log a cycle that has ended; if there is none, when the next one begins."""
        if self._ended is not None:
            return (self._cycle - 1) * self._period_ns + self._log_after_ns
        return self._cycle * self._period_ns

    @property
    def done(self) -> bool:
        """Whether everything is in the log."""
        over = self._core.stopped or self._cycle - self._lag >= self._cycles
        return over and self._ended is None

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a command is refused, or None.

        A command is checked as in lock-step, and its report of timing is checked, too. Links are
        checked in `take_in`, because checking a table means decoding it.
        """
        if topic is LINKS:
            return None
        fault = self._core.fault_in_command(message, vehicle)
        fault = fault or fault_in_timing(message.timing, len(self._vehicles))
        if fault is None and message.timing.clock_error_ns > self._most_error_ns:
            return UNCLOCKED
        return fault

    def take_in(self, post: Post) -> str | None:
        """Keep links and commands, or return why they are refused."""
        if post.topic is LINKS:
            self._linked_ns = post.came_ns
            links = post.message
            is_due = self._oldest <= links.cycle < self._cycle
            return self._tables.take_in(links) if is_due else STALE
        self._commanded_ns = post.came_ns
        if isinstance(post.message, Commands):
            self._commands.wait_together(post.message, post.came_ns)
            return None
        vehicle, cycle = post.vehicle, post.message.cycle
        if not (cycle < self._cycle and self._commands.are_newer((vehicle,), cycle)):
            return STALE
        if not self._attendance.takes_part(vehicle, cycle):
            return FOREIGN
        self._commands.wait(vehicle, cycle, post.payload, post.came_ns)
        return None

    def _decode_jointly(self, parcels: Sequence[Parcel]) -> Commands | None:
        """Return the commands of the vehicles of a shared process; None if any is in doubt."""
        commands = self._core.decode_jointly(parcels)
        if commands is None or not commands.cycle < self._cycle:
            return None
        if not self._commands.are_newer([vehicle for vehicle, _ in parcels], commands.cycle):
            return None
        return commands if are_timings(commands, len(self._vehicles), self._most_error_ns) else None

    @property
    def _oldest(self) -> int:
        """The oldest cycle that is not logged yet."""
        return self._cycle - self._lag

    def act(self, now_ns: int) -> list[Envelope]:
        """Log a cycle that has ended; if there is none, begin the next one.

        Commands that wait become columns with the log, when nobody waits for the world. If others
        wait when a cycle is due, that is all this call does: the cycle begins with the next call,
        which tells how late it is.
        """
        if self._ended is not None:
            self._take_effect()
            ended, self._ended = self._ended, None
            return self._rows_of(ended)
        if self._commands.wait_for_columns:
            self._take_effect()
            return []
        start_ns = self._cycle * self._period_ns
        self._release(start_ns)
        cycle, self._cycle = self._cycle, self._cycle + 1
        self._began_ns[cycle] = now_ns
        self.overruns += cycle <= self._cycles and now_ns - start_ns > self._overrun_ns
        if cycle >= self._lag:
            self._ended = self._end(cycle - self._lag)
        commands = None if self._ended is None else self._ended.commands.fleet
        begun = self._core.begin(cycle, self._wall_start_ns)
        events, self._events = sorted(self._events, key=attrgetter("time_ns")), []
        return [
            *begun.messages,
            *begun.rows,
            *self._core.events(cycle, commands, begun.collided),
            *(Envelope(EVENTS, 0, event.SerializeToString(), event.time_ns) for event in events),
        ]

    def _take_effect(self) -> None:
        """Let the commands take effect that wait."""
        for arrived in self._commands.arrived():
            rows = arrived.commands.rows
            self._core.take_in(rows)
            self._events += self._silent.heard(rows, arrived.came_ns)
            self._commands.keep(arrived, self._oldest)

    def _release(self, until_ns: int) -> None:
        """Let vehicles roll that have fallen silent, from that instant on."""
        silent = self._silent.falling_silent(until_ns)
        for event in silent:
            self._core.let_roll(event.vehicle, event.time_ns)
        self._events += silent

    def _end(self, cycle: int) -> _EndedCycle:
        """Collect all messages about a cycle that is to be logged."""
        return _EndedCycle(
            cycle=cycle,
            began_ns=self._began_ns.pop(cycle),
            tables=self._tables.take_out(cycle),
            receivers=self._commands.parts(cycle + self._decided_later),
            commands=self._commands.take_out(cycle),
        )

    def _rows_of(self, ended: _EndedCycle) -> list[Envelope]:
        """Return the rows of the log for a cycle that has ended."""
        cycle, start_ns = ended.cycle, ended.cycle * self._period_ns
        size, decided = len(self._vehicles), cycle + self._decided_later
        timings = Timings(size, ended.commands.parts)
        receivers = None
        if decided < self._cycles:
            receivers = Timings(size, ended.receivers) if self._decided_later else timings
        there = self._attendance.there(decided)
        frames = frames_of(cycle, start_ns, ended.tables, receivers, there)
        timing = realtime_row(
            cycle=cycle,
            time_ns=start_ns,
            began_ns=ended.began_ns,
            deadline_ns=start_ns + self._effect_ns,
            timings=timings,
        )
        return [*self._core.rows(cycle, frames, ended.commands.fleet), timing]
