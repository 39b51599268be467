"""The world on the wall clock: the agent of lock-step, with whatever commands have come by then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.checks import flaw_of_timing
from zenvoy.bus.live import Post
from zenvoy.bus.topics import EVENTS, LINKS, Topic
from zenvoy.scenarios import Scenario
from zenvoy.world.agent import WorldAgent
from zenvoy.world.live_rows import (
    Columns,
    as_heard,
    frame_columns,
    joined,
    links_of,
    no_command,
    realtime_row,
)

_OVERRUN_NS: Final = 1_000_000  # a cycle that begins later than this, of wall time, has overrun


_Came = tuple[pb.Command, int]
"""A command, and when it came (ns)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _EndedCycle:
    """All that has come about a cycle that has ended.

    hearers: the commands whose decisions its frames were due for; None: the run ends before those.
    """

    cycle: int
    began_ns: int
    frames: list[Columns]
    commands: dict[int, _Came]  # by vehicle
    hearers: list[pb.Command] | None


class LiveWorld:
    """Senses at each t_k, whatever has come by then.

    A command takes effect at its time, or on arrival if that is later. A vehicle that sends none
    keeps its last acceleration for as long as beacons count (`beacon_age_limit_ms`), then rolls.
    A cycle is logged one cycle after its commands were to take effect, three quarters through it:
    then no other process waits for this one.
    """

    role = "world"
    name = "world"
    vehicles = ()
    sends_together = False
    may_wait: frozenset[Topic[Any]] = frozenset()

    def __init__(self, scenario: Scenario) -> None:
        self._world = WorldAgent(scenario)
        self._vehicles = range(1, scenario.fleet.size + 1)
        self._period_ns, self._cycles = scenario.period_ns, scenario.cycles
        self._wait_ns = scenario.v2v_wait_ns
        self._effect_ns = scenario.v2v_wait_ns + scenario.system_delay_ns
        self._hold_ns = scenario.beacon_age_limit_ns
        self._overrun_ns = round(_OVERRUN_NS * scenario.speed)
        # Frames count in the decision of their own cycle, or of the next one (docs/decisions.md).
        self._ahead = 0 if self._wait_ns else 1
        self._quiet_ns = 3 * self._period_ns // 4
        self._lag = 1 + self._ahead + -(-self._effect_ns // self._period_ns)
        self._cycle = 0  # the next
        self._newest = dict.fromkeys(self._vehicles, -1)  # cycle of the newest command of each
        self._acts_ns = dict.fromkeys(self._vehicles, 0)  # when that took effect
        self._silent: set[int] = set()
        self._events: list[pb.Event] = []
        self._began_ns: dict[int, int] = {}
        self._commands: dict[int, dict[int, _Came]] = {}  # by cycle and vehicle
        self._frames: dict[int, list[Columns]] = {}
        self._over: _EndedCycle | None = None  # what is to be told next
        self._linked_ns = 0  # when the channel last told of a cycle
        self._commanded_ns = 0  # when a vehicle last sent a command
        self.overruns = 0

    @property
    def channel_silent_ns(self) -> int:
        """How long vehicles have sent commands, and so beacons, while the channel told of none."""
        return self._commanded_ns - self._linked_ns

    def start(self, wall_start_ns: int) -> None:
        """Say when time 0 is, for the vehicles and the channel to know."""
        self._world.wall_start_ns = wall_start_ns

    @property
    def due_ns(self) -> int:
        """When to log a cycle that has ended, or else when the next one begins."""
        if self._over is not None:
            return (self._cycle - 1) * self._period_ns + self._quiet_ns
        return self._cycle * self._period_ns

    @property
    def done(self) -> bool:
        """Whether everything is in the log."""
        ended = self._world.stopped or self._cycle - self._lag >= self._cycles
        return ended and self._over is None

    def flaw(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """As in lock-step; a command's report of the clock is logged as well."""
        flaw = self._world.flaw(topic, vehicle, message)
        if flaw is not None or topic is LINKS:
            return flaw
        return flaw_of_timing(message.timing, len(self._vehicles))

    def hear(self, post: Post) -> bool:
        """Keep the channel's frames; let a command take effect at its time, or now if it is late.

        Both are kept for the log up to the cycle in which their own cycle is logged. A vehicle's
        commands count in order of cycle: one that comes after a newer one is refused.
        """
        cycle = post.message.cycle
        oldest = self._cycle - self._lag  # of the cycles that are still to be logged
        if post.topic is LINKS:
            self._linked_ns = post.came_ns
            return oldest <= cycle < self._cycle and self._keep(cycle, post.message.frames)
        self._commanded_ns = post.came_ns
        command: pb.Command = post.message
        if not self._newest[post.vehicle] < cycle < self._cycle:
            return False
        self._newest[post.vehicle] = cycle
        command.effective_ns = max(command.effective_ns, post.came_ns)
        self._world.command([command])
        self._acts_ns[post.vehicle] = command.effective_ns
        if post.vehicle in self._silent:
            self._silent.remove(post.vehicle)
            self._note(pb.EVENT_SILENT_END, post.vehicle, post.came_ns)
        if cycle >= oldest:
            self._commands.setdefault(cycle, {})[post.vehicle] = (command, post.came_ns)
        return True

    def _keep(self, cycle: int, frames: bytes) -> bool:
        """Keep a table of frames; False where it is damaged, or repeats a sender of this cycle."""
        try:
            table = frame_columns(frames)
        except ValueError:
            return False
        tables = self._frames.setdefault(cycle, [])
        if any(np.isin(table["source"], kept["source"]).any() for kept in tables):
            return False
        if not tables or len(table["source"]):
            tables.append(table)
        return True

    def act(self, now_ns: int) -> list[Envelope]:
        """Log a cycle that has ended, or else begin the next one."""
        if self._over is not None:
            over, self._over = self._over, None
            return self._past(over)
        cycle, self._cycle = self._cycle, self._cycle + 1
        start_ns = cycle * self._period_ns
        self._began_ns[cycle] = now_ns
        self.overruns += cycle <= self._cycles and now_ns - start_ns > self._overrun_ns
        self._release(start_ns)
        if cycle >= self._lag:
            self._over = self._end(cycle - self._lag)
        commands = self._over.commands if self._over is not None else {}
        now_ns = min(start_ns, self._cycles * self._period_ns)
        events, self._events = self._events, []
        return [
            *self._world.proceed(cycle, now_ns, [command for command, _ in commands.values()], []),
            *(Envelope(EVENTS, 0, event.SerializeToString(), event.time_ns) for event in events),
        ]

    def _release(self, until_ns: int) -> None:
        """Set the acceleration of vehicles that have sent no command for too long to 0."""
        for vehicle, acts_ns in self._acts_ns.items():
            ends_ns = acts_ns + self._hold_ns
            if ends_ns <= until_ns and vehicle not in self._silent:
                self._silent.add(vehicle)
                self._world.command([pb.Command(vehicle=vehicle, effective_ns=ends_ns)])
                self._note(pb.EVENT_SILENT, vehicle, ends_ns)

    def _note(self, kind: pb.EventKind.ValueType, vehicle: int, time_ns: int) -> None:
        cycle = time_ns // self._period_ns
        self._events.append(pb.Event(cycle=cycle, time_ns=time_ns, kind=kind, vehicle=vehicle))

    def _end(self, cycle: int) -> _EndedCycle:
        """What is known of a cycle that is over."""
        hearers = None
        if cycle + self._ahead < self._cycles:
            hearers = self._commands.get(cycle + self._ahead, {})
        return _EndedCycle(
            cycle=cycle,
            began_ns=self._began_ns.pop(cycle),
            frames=self._frames.pop(cycle, []),
            commands=self._commands.pop(cycle, {}),
            hearers=None if hearers is None else [command for command, _ in hearers.values()],
        )

    def _past(self, over: _EndedCycle) -> list[Envelope]:
        """Rows of the log about a cycle that is over."""
        cycle, start_ns = over.cycle, over.cycle * self._period_ns
        frames = joined(over.frames)
        if over.hearers is not None:
            frames = as_heard(frames, over.hearers)
        nothing = no_command(cycle, start_ns + self._wait_ns)
        rows = [over.commands.get(vehicle, (nothing, -1)) for vehicle in self._vehicles]
        commands = [command for command, _ in rows]
        timing = realtime_row(
            cycle=cycle,
            time_ns=start_ns,
            began_ns=over.began_ns,
            deadline_ns=start_ns + self._effect_ns,
            commands=commands,
            came_ns=[came_ns for _, came_ns in rows],
        )
        return [*self._world.past(commands, links_of(cycle, start_ns, frames)), timing]
