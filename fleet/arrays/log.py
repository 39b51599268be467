"""The log of one run of a batch: the messages that the in-process bus would log, in its order."""

from __future__ import annotations

from collections import deque

import numpy as np

from zenvoy.bus.agent import Envelope, Log
from zenvoy.bus.topics import ESTIMATE, FLEET_COMMAND, FRAMES
from zenvoy.channel.agent import frame_table
from zenvoy.channel.transmission import Transmission
from zenvoy.fleet.arrays.batch import Batch, Cycle
from zenvoy.fleet.arrays.columns import estimate_columns, logged_columns
from zenvoy.fleet.arrays.happenings import Happenings
from zenvoy.links.sent_frames import Scene
from zenvoy.scenarios import roster
from zenvoy.vehicles.arrays.beaconing import Beaconing
from zenvoy.world.rows import radar_row, row_of, truth_row
from zenvoy.world.sensors import Readings


class RunLog:
    """Writes the messages of one run of a `whole` batch to `log`, cycle by cycle."""

    def __init__(self, batch: Batch, run: int, log: Log) -> None:
        scenario = batch.scenarios[run]
        size = scenario.fleet.size
        self._log = log
        self._scenario = scenario
        self._part = slice(run * size, (run + 1) * size)
        self._run, self._size = run, size
        self._transmission = Transmission(scenario)
        self._beaconing = Beaconing(scenario, roster(scenario))
        self._happenings = Happenings(scenario, 1)
        self._past: deque[list[Envelope]] = deque()
        self._estimates = estimate_columns(scenario)
        self._logged = [column for _, column in logged_columns(scenario)]
        self.stopped = False
        """Whether a collision has ended the run."""

    def take(self, cycle: Cycle) -> None:
        """Log what a cycle makes known; after the last cycle, log all that remains."""
        if self.stopped:
            return
        collided = [index for run, index in cycle.collided if run == self._run]
        self.stopped = bool(collided) and self._scenario.on_collision == "stop"
        time_ns = cycle.number * self._scenario.period_ns
        part = self._part
        acceleration = cycle.acceleration[part]
        truth = truth_row(
            cycle.number, time_ns, cycle.position[part], cycle.speed[part], acceleration
        )
        rows = [truth]
        if cycle.senses is not None and not self.stopped:
            read = cycle.senses
            readings = Readings(
                read.gap[part], read.relative_speed[part], read.position[part], read.speed[part]
            )
            rows.append(radar_row(cycle.number, time_ns, readings, acceleration))
        self._write(time_ns, rows, collided)
        if self.stopped:
            return
        if cycle.senses is None:
            while self._past:
                self._write(time_ns, [], [], over=True)
        else:
            self._past.append(self._rows(cycle))

    def _write(
        self, time_ns: int, rows: list[Envelope], collided: list[int], *, over: bool = False
    ) -> None:
        """Log a step of the world: the cycle that has ended, the one that begins, and events."""
        ended: list[Envelope] = []
        if over or len(self._past) > self._happenings.lookahead:
            ended = self._past.popleft()
        found = self._happenings.step(time_ns, [(0, index) for index in collided], over=over)
        for envelope in (*ended, *rows, *found.get(0, ())):
            self._say(envelope)

    def _say(self, envelope: Envelope) -> None:
        self._log(envelope.topic, envelope.time_ns, envelope.payload)

    def _rows(self, cycle: Cycle) -> list[Envelope]:
        """Return the messages about a cycle that are logged when it has ended."""
        scenario, part, decisions = self._scenario, self._part, cycle.decisions
        assert decisions is not None
        time_ns = cycle.number * scenario.period_ns
        decided_ns = time_ns + scenario.v2v_wait_ns
        columns = {name: column(cycle)[part] for name, column in self._estimates.items()}
        columns["logged"] = np.concatenate(
            [np.zeros(0), *(column(cycle)[part] for column in self._logged)]
        )
        effective_ns = decided_ns + scenario.system_delay_ns
        commands = {
            "acceleration": decisions.acceleration[part],
            "effective_ns": np.full(self._size, effective_ns),
        }
        self._happenings.decide(decisions.mode[part], decided_ns)
        return [
            Envelope(FRAMES, 0, self._frames(cycle, time_ns), time_ns),
            row_of(ESTIMATE, cycle.number, decided_ns, columns),
            row_of(FLEET_COMMAND, cycle.number, decided_ns, commands),
        ]

    def _frames(self, cycle: Cycle, time_ns: int) -> bytes:
        speaks, sequence = self._beaconing.at(cycle.number)
        position = cycle.position[self._part]
        scene = Scene(cycle.number, time_ns, position, self._scenario.ring_length_m)
        return frame_table(scene, self._transmission.of(speaks, sequence, scene))
