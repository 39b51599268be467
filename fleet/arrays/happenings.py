"""The events of runs side by side: the entries of their logs under `/events`."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.rows import Ints
from zenvoy.world.chronicle import Chronicle
from zenvoy.world.fallbacks import Fallbacks, fallback_event
from zenvoy.world.lock_step import lookahead


class Happenings:
    """The events of `runs` runs of a scenario, for each step of the world.

    A run takes time only in the steps in which something happens in it.
    """

    def __init__(self, scenario: Scenario, runs: int) -> None:
        self.lookahead = lookahead(scenario)
        """Cycles by which the world is ahead of the decisions that it has received."""
        self._size = scenario.fleet.size
        self._stops = scenario.on_collision == "stop"
        self._going = {run: Chronicle(scenario) for run in range(runs)}
        self._members = np.arange(runs * self._size)
        self._fallbacks = Fallbacks(runs * self._size)
        self._past: deque[dict[int, list[pb.Event]]] = deque()
        self.stopped: dict[int, int] = {}
        """The time of the collision that has ended a run, ns, by run."""

    @property
    def all_stopped(self) -> bool:
        """Whether a collision has ended every run."""
        return not self._going

    def decide(self, mode: Ints, decided_ns: int) -> None:
        """Record the modes of a cycle's decisions, (runs · n,); a later step logs their changes."""
        news: dict[int, list[pb.Event]] = defaultdict(list)
        for member, falls in self._fallbacks.take_in(self._members, mode):
            run, index = divmod(member, self._size)
            news[run].append(fallback_event(index + 1, falls, decided_ns))
        self._past.append(news)

    def step(
        self, time_ns: int, collided: Sequence[tuple[int, int]], *, over: bool = False
    ) -> dict[int, list[Envelope]]:
        """Return what a step of the world adds to `/events`, by run.

        A step logs the oldest decisions that no step has logged, if the world has received them.
        collided lists the vehicles that have run into the vehicle ahead, by run and index. With
        `over` the run has ended, and only decisions are left to log.
        """
        knows = over or len(self._past) > self.lookahead
        news = self._past.popleft() if knows and self._past else {}
        fallen: dict[int, list[int]] = defaultdict(list)
        for run, index in collided:
            fallen[run].append(index)
        touched = {*news, *fallen} & self._going.keys()
        if self._is_due(time_ns):
            touched = set(self._going)
        found = {}
        for run in sorted(touched):
            indices = fallen.get(run, [])
            found[run] = self._going[run].write(time_ns, news.get(run, ()), indices)
            if indices and self._stops:
                found[run].append(self._going.pop(run).stop(time_ns, "collision"))
                self.stopped[run] = time_ns
        return found

    def _is_due(self, time_ns: int) -> bool:
        """Return whether an event is due by now; all runs have the same schedule."""
        going = next(iter(self._going.values()), None)
        due_ns = None if going is None else going.due_ns
        return due_ns is not None and due_ns <= time_ns
