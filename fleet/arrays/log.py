"""The log of one run of a batch: the messages that the in-process bus would log, in its order."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Final

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope, Log
from zenvoy.bus.topics import ESTIMATE, FLEET_COMMAND, FRAMES
from zenvoy.channel.agent import frame_table
from zenvoy.channel.transmission import Transmission
from zenvoy.fleet.arrays.batch import Batch, Cycle
from zenvoy.laws import law_of
from zenvoy.links.rows import Scene
from zenvoy.scenarios import modes, roster
from zenvoy.vehicles.arrays.beaconing import Beaconing
from zenvoy.world.chronicle import Chronicle
from zenvoy.world.lock_step import lookahead
from zenvoy.world.rows import radar_row, row_of, truth_row
from zenvoy.world.sensors import Readings

_FALLS_BACK: Final = pb.MODE_FALLBACK_FM


class RunLog:
    """Takes in the cycles of a `whole` batch; gives what run number `run` of it logs to `log`."""

    def __init__(self, batch: Batch, run: int, log: Log) -> None:
        scenario = batch.scenarios[run]
        size = scenario.fleet.size
        self._log = log
        self._scenario = scenario
        self._part = slice(run * size, (run + 1) * size)
        self._run, self._size = run, size
        self._transmission = Transmission(scenario)
        self._beaconing = Beaconing(scenario, roster(scenario))
        self._chronicle = Chronicle(scenario)
        self._lookahead = lookahead(scenario)
        self._past: deque[tuple[list[Envelope], list[pb.Command]]] = deque()
        self._fallen_back = np.zeros(size, dtype=np.bool_)
        self._columns = {
            mode: len(law_of(model).columns)
            for model, mode in sorted(modes(scenario).items(), key=lambda one: one[1])
        }
        self._counts_neighbours = any(
            law_of(model).needs.sides for one in roster(scenario) for model in one.models
        )
        self.stopped = False
        """Whether a collision has ended the run."""

    def take(self, cycle: Cycle) -> None:
        """Log what becomes known with a cycle; after the last one, all that is left."""
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
        if cycle.readings is not None and not self.stopped:
            read = cycle.readings
            readings = Readings(
                read.gap[part], read.relative_speed[part], read.position[part], read.speed[part]
            )
            rows.append(radar_row(cycle.number, time_ns, readings, acceleration))
        self._write(time_ns, rows, collided)
        if self.stopped:
            self._say(self._chronicle.stop(time_ns, "collision"))
        elif cycle.readings is None:
            while self._past:
                self._write(time_ns, [], [])
        else:
            self._past.append(self._rows(cycle))

    def _write(self, time_ns: int, rows: list[Envelope], collided: list[int]) -> None:
        """Log a step of the world: what has ended by then, what begins, and events."""
        ended: list[Envelope] = []
        commands: list[pb.Command] = []
        if len(self._past) > self._lookahead or not rows:
            ended, commands = self._past.popleft()
        for envelope in (*ended, *rows, *self._chronicle.write(time_ns, commands, collided)):
            self._say(envelope)

    def _say(self, envelope: Envelope) -> None:
        self._log(envelope.topic, envelope.time_ns, envelope.payload)

    def _rows(self, cycle: Cycle) -> tuple[list[Envelope], list[pb.Command]]:
        """The rows about a cycle that are logged when it has ended, and news of fallbacks."""
        scenario, part, decisions = self._scenario, self._part, cycle.decisions
        assert decisions is not None
        assert cycle.estimates is not None
        time_ns = cycle.number * scenario.period_ns
        decided_ns = time_ns + scenario.v2v_wait_ns
        columns = {name: values[part].tolist() for name, values in cycle.estimates.items()}
        if self._counts_neighbours:
            columns["neighbours"] = decisions.neighbours[part].tolist()
        columns["logged"] = list(self._logged(cycle))
        effective_ns = decided_ns + scenario.system_delay_ns
        commands = {
            "acceleration": decisions.acceleration[part].tolist(),
            "effective_ns": [effective_ns] * self._size,
        }
        rows = [
            Envelope(FRAMES, 0, self._frames(cycle, time_ns), time_ns),
            row_of(ESTIMATE, cycle.number, decided_ns, columns),
            row_of(FLEET_COMMAND, cycle.number, decided_ns, commands),
        ]
        return rows, self._changed(columns["mode"], decided_ns)

    def _frames(self, cycle: Cycle, time_ns: int) -> bytes:
        speaks, sequence = self._beaconing.at(cycle.number)
        position = cycle.position[self._part]
        scene = Scene(cycle.number, time_ns, position, self._scenario.ring_length_m)
        return frame_table(scene, self._transmission.of(speaks, sequence, scene))

    def _logged(self, cycle: Cycle) -> Iterator[float]:
        """What laws log, column by column; NaN where a vehicle is under another law."""
        assert cycle.decisions is not None
        mode, logged = cycle.decisions.mode[self._part], cycle.decisions.logged
        for number, count in self._columns.items():
            for index in range(count):
                found = logged.get(number)
                if found is None:
                    yield from [np.nan] * self._size
                else:
                    values = found[index][self._part]
                    yield from np.where(mode == number, values, np.nan).tolist()

    def _changed(self, mode: list[int], decided_ns: int) -> list[pb.Command]:
        """Commands of those alone who begin or cease to fall back."""
        falls = np.array(mode) == _FALLS_BACK
        changed = np.flatnonzero(falls != self._fallen_back)
        self._fallen_back = falls
        return [
            pb.Command(vehicle=index + 1, mode=pb.Mode.ValueType(mode[index]), time_ns=decided_ns)
            for index in changed.tolist()
        ]
