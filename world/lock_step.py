"""The world in lock-step: it begins a cycle once it has the commands that take effect before it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from zenvoy.bus.agent import Barrier, Envelope, Inbox, JointDecoder
from zenvoy.bus.errors import VehicleLostError
from zenvoy.bus.latecomers import Late
from zenvoy.bus.refusals import FOREIGN, RefusedError
from zenvoy.bus.topics import COMMAND, LINKS, Topic
from zenvoy.scenarios import Scenario, attendance
from zenvoy.world.agent import World
from zenvoy.world.commands import Commands, FleetCommands, joined
from zenvoy.world.pace import Pace

_FARTHEST: Final = 2  # cycles ahead; more would overlap no more work and only fill queues


class LockStepWorld:
    """Step k moves the vehicles to t_k and begins cycle k, up to the end of the last cycle.

    Step k needs the commands that take effect before t_k. Because of the V2V delays these are older
    than those of cycle k - 1. So the world runs `lookahead` cycles ahead of the newest commands,
    and the cycles of world, channel and vehicles overlap. Steps after the end only log what is
    still to come. The world sends what vehicles wait for first, and writes the log while they work.
    """

    role = "world"
    name = "world"
    vehicles = ()

    def __init__(self, scenario: Scenario) -> None:
        self._core = World(scenario)
        self._period_ns, self._cycles = scenario.period_ns, scenario.cycles
        self._attendance = attendance(scenario)
        self._lookahead = lookahead(scenario)
        self._step = 0
        self.pace = Pace(together=self._lookahead > 0)
        self.joint_decoders: Mapping[Topic[Any], JointDecoder] = {
            COMMAND: self._core.decode_jointly
        }

    @property
    def barrier(self) -> Barrier | None:
        """The messages that the next step needs: commands and links of the newest cycle for it."""
        newest = self._step - 1 - self._lookahead
        now_ns = min(self._step, self._cycles) * self._period_ns
        if self._core.lost:
            return Barrier(now_ns, newest)  # for a step that only says so
        if self._core.stopped or newest == self._cycles:
            return None
        joins = self._attendance.joining_at(self._step)
        if newest < 0:
            return Barrier(now_ns, 0, joins=joins)
        # Topics are awaited in this order, and a stall is blamed on the first missing message. So
        # the single message of the channel comes before those of all vehicles.
        needs = ((LINKS, (0,)), (COMMAND, self._attendance.there(newest)))
        return Barrier(now_ns, newest, needs, joins)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a message is refused, or None.

        Commands and links must have the times of their cycle.
        """
        if topic is not LINKS:
            if not self._attendance.takes_part(vehicle, message.cycle):
                return FOREIGN
            return self._core.fault_in_command(message, vehicle)
        try:
            self._core.table_of(message)
        except RefusedError as refused:
            return refused.reason
        return None

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Move the vehicles to `now_ns`, begin a cycle there, and log what has become known.

        Raises VehicleLostError a step after a loss has ended the run, so that its end is logged.
        """
        if self._core.lost:
            raise VehicleLostError(self._core.lost, (self._step - 1) * self._period_ns * 1e-9)
        cycle, self._step = self._step, self._step + 1
        ended = cycle - 1 - self._lookahead  # the cycle whose commands and links are in the inbox
        commands, rows = None, []
        if ended >= 0:
            commands = self._taken_from(inbox)
            links = inbox.one(LINKS)
            rows = self._core.rows(ended, links.frames, commands)
            if inbox.late is not None:
                self.pace.add((inbox.late, Late(links.late_host, links.late_ns)))
        begun = self._core.begin(cycle)
        events = self._core.events(cycle, commands, begun.collided)
        return [*begun.messages, *rows, *begun.rows, *events]

    def _taken_from(self, inbox: Inbox) -> FleetCommands:
        """Take in the commands of a cycle, those of shared processes and all others."""
        together: dict[int, Commands] = {}
        alone = []
        for one, payload in inbox.with_payloads(COMMAND):
            if isinstance(one, Commands):
                together[id(one)] = one
            else:
                alone.append(payload)
        parts = list(together.values())
        if alone:
            parts.append(self._core.command_reader.read(alone))
        found = self._core.no_commands()
        if parts:  # else all vehicles are away
            commands = joined(parts)
            self._core.take_in(commands.rows)
            found.put(commands)
        return found


def lookahead(scenario: Scenario) -> int:
    """Return by how many cycles the world runs ahead of the newest commands that it has."""
    delay_ns = scenario.v2v_wait_ns + scenario.system_delay_ns
    return min(delay_ns // scenario.period_ns, _FARTHEST)
