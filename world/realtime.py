"""The world in real time: it begins each cycle on time, with the commands that have arrived."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope, Reader
from zenvoy.bus.bundles import Parcel
from zenvoy.bus.checks import fault_in_timing
from zenvoy.bus.frame_table import FrameTable
from zenvoy.bus.realtime_agent import Post
from zenvoy.bus.refusals import FOREIGN, STALE, UNCLOCKED, RefusedError
from zenvoy.bus.topics import COMMAND, EVENTS, LINKS, Topic
from zenvoy.scenarios import Scenario, attendance
from zenvoy.world.agent import World
from zenvoy.world.commands import Commands, FleetCommands
from zenvoy.world.realtime_rows import frames_of, realtime_row
from zenvoy.world.timings import Timings, are_timings

_OVERRUN_NS: Final = 1_000_000  # of wall time; a cycle that begins later than this has overrun


class _Arrived(NamedTuple):
    """The commands of a cycle that have arrived, and their timing."""

    commands: FleetCommands
    timings: Timings


@dataclass(frozen=True, slots=True, kw_only=True)
class _EndedCycle:
    """All messages about a cycle that has ended.

    receivers: what the commands report whose decisions should use its frames; None if the run ends
    before.
    """

    cycle: int
    began_ns: int
    tables: list[FrameTable]
    arrived: _Arrived
    receivers: Timings | None


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
        self._hold_ns = scenario.beacon_age_limit_ns
        self._most_error_ns = scenario.max_clock_error_ns
        self._attendance = attendance(scenario)
        self._overrun_ns = round(_OVERRUN_NS * scenario.speed)
        # Frames count in the decision of their own cycle, or of the next one (docs/decisions.md).
        self._decided_later = 0 if scenario.v2v_wait_ns else 1
        self._log_after_ns = 3 * self._period_ns // 4
        self._lag = 1 + self._decided_later + -(-self._effect_ns // self._period_ns)
        self._wall_start_ns = 0
        self._cycle = 0  # the next to begin
        size = len(self._vehicles)
        self._newest = np.full(size, -1)  # cycle of each vehicle's newest command
        self._acts_ns = np.zeros(size, dtype=np.int64)  # when that command took effect
        self._silent = np.zeros(size, dtype=np.bool_)  # who has sent no command for too long
        self._events: list[pb.Event] = []  # logged when the next cycle begins
        # Messages about the cycles that are not logged yet, by cycle.
        self._began_ns: dict[int, int] = {}
        self._arrived: dict[int, _Arrived] = {}
        self._tables: dict[int, list[FrameTable]] = {}
        self._ended: _EndedCycle | None = None  # the next cycle to be logged
        self._linked_ns = 0  # when the channel last sent a table
        self._commanded_ns = 0  # when a vehicle last sent a command
        self.overruns = 0
        self.readers: Mapping[Topic[Any], Reader] = {COMMAND: self._together}

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
        """Keep links and commands, or return why they are refused.

        A command takes effect at its time, or now if it is late.
        """
        if post.topic is LINKS:
            self._linked_ns = post.came_ns
            return self._take_in_links(post.message)
        self._commanded_ns = post.came_ns
        if isinstance(post.message, Commands):
            self._take_in_commands(post.message, post.came_ns)
            return None
        cycle = post.message.cycle
        if not self._newest[post.vehicle - 1] < cycle < self._cycle:
            return STALE
        if not self._attendance.takes_part(post.vehicle, cycle):
            return FOREIGN
        self._take_in_commands(self._core.commands.each([post.payload]), post.came_ns)
        return None

    def _together(self, parcels: Sequence[Parcel]) -> Commands | None:
        """Return the commands of the vehicles of a shared process; None if any is in doubt."""
        vehicles, payloads = zip(*parcels, strict=True)
        commands = self._core.commands.flat(payloads)
        if commands is None or not self._core.are_sound(commands, vehicles):
            return None
        cycle, newest = commands.cycle, self._newest[np.array(vehicles) - 1]
        if not ((newest < cycle).all() and cycle < self._cycle):
            return None
        if not all(self._attendance.takes_part(vehicle, cycle) for vehicle in vehicles):
            return None
        return commands if are_timings(commands, len(self._vehicles), self._most_error_ns) else None

    def _take_in_links(self, links: pb.Links) -> str | None:
        """Keep a table until its cycle is logged; refuse one that repeats a sender."""
        if not self._oldest <= links.cycle < self._cycle:
            return STALE
        try:
            table = self._core.table_of(links)
        except RefusedError as refused:
            return refused.reason
        kept = self._tables.setdefault(links.cycle, [])
        source = table.columns["source"]
        if any(np.isin(source, one.columns["source"]).any() for one in kept):
            return STALE
        if not kept or len(source):
            kept.append(table)
        return None

    def _take_in_commands(self, commands: Commands, came_ns: int) -> None:
        """Keep commands of one cycle, each newer than that of its vehicle before it."""
        rows, cycle = commands.rows, commands.cycle
        at = rows["vehicle"].astype(np.intp) - 1
        self._newest[at] = cycle
        rows["effective_ns"] = np.maximum(rows["effective_ns"], came_ns)
        self._core.take_in(rows)
        self._acts_ns[at] = rows["effective_ns"]
        for index in at[self._silent[at]].tolist():
            self._note(pb.EVENT_SILENT_END, index + 1, came_ns)
        self._silent[at] = False
        if cycle >= self._oldest:
            arrived = self._arrived.setdefault(cycle, self._none_arrived())
            arrived.commands.put(commands)
            arrived.timings.put(commands, came_ns)

    def _none_arrived(self) -> _Arrived:
        return _Arrived(self._core.no_commands(), Timings(len(self._vehicles)))

    @property
    def _oldest(self) -> int:
        """The oldest cycle that is not logged yet."""
        return self._cycle - self._lag

    def act(self, now_ns: int) -> list[Envelope]:
        """Log a cycle that has ended; if there is none, begin the next one."""
        if self._ended is not None:
            ended, self._ended = self._ended, None
            return self._rows_of(ended)
        cycle, self._cycle = self._cycle, self._cycle + 1
        start_ns = cycle * self._period_ns
        self._began_ns[cycle] = now_ns
        self.overruns += cycle <= self._cycles and now_ns - start_ns > self._overrun_ns
        self._release(start_ns)
        if cycle >= self._lag:
            self._ended = self._end(cycle - self._lag)
        commands = None if self._ended is None else self._ended.arrived.commands
        begun = self._core.begin(cycle, self._wall_start_ns)
        events, self._events = self._events, []
        return [
            *begun.messages,
            *begun.rows,
            *self._core.events(cycle, commands, begun.collided),
            *(Envelope(EVENTS, 0, event.SerializeToString(), event.time_ns) for event in events),
        ]

    def _release(self, until_ns: int) -> None:
        """Let vehicles roll if they have sent no command for too long.

        What a vehicle does whose process the scenario has killed or frozen is up to the scenario.
        """
        for vehicle in self._attendance.absences:
            if not self._attendance.takes_part(vehicle, until_ns // self._period_ns):
                self._acts_ns[vehicle - 1] = until_ns
        ends_ns = self._acts_ns + self._hold_ns
        for index in np.flatnonzero((ends_ns <= until_ns) & ~self._silent).tolist():
            self._core.let_roll(index + 1, int(ends_ns[index]))
            self._note(pb.EVENT_SILENT, index + 1, int(ends_ns[index]))
        self._silent |= ends_ns <= until_ns

    def _note(self, kind: pb.EventKind.ValueType, vehicle: int, time_ns: int) -> None:
        cycle = time_ns // self._period_ns
        self._events.append(pb.Event(cycle=cycle, time_ns=time_ns, kind=kind, vehicle=vehicle))

    def _end(self, cycle: int) -> _EndedCycle:
        """Collect all messages about a cycle that is to be logged."""
        decided = cycle + self._decided_later
        receivers = None
        if decided < self._cycles:
            receivers = self._arrived.get(decided, self._none_arrived()).timings
        return _EndedCycle(
            cycle=cycle,
            began_ns=self._began_ns.pop(cycle),
            tables=self._tables.pop(cycle, []),
            receivers=receivers,
            arrived=self._arrived.pop(cycle, self._none_arrived()),
        )

    def _rows_of(self, ended: _EndedCycle) -> list[Envelope]:
        """Return the rows of the log for a cycle that has ended."""
        cycle, start_ns = ended.cycle, ended.cycle * self._period_ns
        there = self._attendance.there(cycle + self._decided_later)
        frames = frames_of(cycle, start_ns, ended.tables, ended.receivers, there)
        timing = realtime_row(
            cycle=cycle,
            time_ns=start_ns,
            began_ns=ended.began_ns,
            deadline_ns=start_ns + self._effect_ns,
            timings=ended.arrived.timings,
        )
        return [*self._core.rows(cycle, frames, ended.arrived.commands), timing]
