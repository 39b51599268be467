"""How often, and for how long, each machine holds up the steps of a run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, NamedTuple

from zenvoy.bus.latecomers import Late

_WORTH_NOTING_NS: Final = 1_000_000  # less is the order in which processes get their turn
_WORTH_TELLING: Final = 0.25  # of the wall time of the run


class HeldUp(NamedTuple):
    """A machine that held up a share of the steps, each by a mean time, ns."""

    host: str
    share: float
    by_ns: int


@dataclass(slots=True)
class _Sum:
    steps: int = 0
    total_ns: int = 0


class Pace:
    """Adds up for whom the steps of a run have waited.

    together: whether world and channel wait for a machine at the same time, because the world runs
    ahead of the commands. Otherwise one wait comes after the other.
    """

    def __init__(self, *, together: bool) -> None:
        self._together = together
        self._steps = 0
        self._by_host: dict[str, _Sum] = {}

    def add(self, lates: Iterable[Late | None]) -> None:
        """Add a step, with the machines for which world and channel have waited alone."""
        self._steps += 1
        waits_ns: dict[str, int] = {}
        for late in lates:
            if late is not None and late.host:
                before_ns = waits_ns.get(late.host, 0)
                both_ns = max(before_ns, late.by_ns) if self._together else before_ns + late.by_ns
                waits_ns[late.host] = both_ns
        for host, waited_ns in waits_ns.items():
            if waited_ns >= _WORTH_NOTING_NS:
                found = self._by_host.setdefault(host, _Sum())
                found.steps += 1
                found.total_ns += waited_ns

    def slowest(self, wall_ns: int) -> HeldUp | None:
        """Return the machine that has cost the most time in a run of `wall_ns` so far.

        None if that is less than a quarter of the time: in any run somebody comes last.
        """
        if not self._by_host:
            return None
        host, found = max(self._by_host.items(), key=lambda one: one[1].total_ns)
        if found.total_ns < _WORTH_TELLING * wall_ns:
            return None
        return HeldUp(host, found.steps / self._steps, found.total_ns // found.steps)
