"""Which machine a participant waits for alone, and how long."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple, TypeVar

from zenvoy.bus.clock import WallClock, wall_ns

T = TypeVar("T")


class Late(NamedTuple):
    """A machine whose messages came last, and how long a step waited for nobody else, ns."""

    host: str
    by_ns: int


class Latecomers:
    """Measures how long each step waits for the messages of a single machine.

    Only waiting counts: messages that are in the queue already, and are read one after the other,
    are not late. `hosts` has the machine of each vehicle, as far as it is known.
    """

    def __init__(self, clock: WallClock = wall_ns) -> None:
        self.hosts: Final[dict[int, str]] = {}
        self._clock = clock
        self._waited_ns = 0  # in this step
        self._last_ns: dict[str, int] = {}  # by machine: time waited before its last message

    def timed(self, wait: Callable[[Callable[[], T]], T], receive: Callable[[], T]) -> T:
        """Return the result of a blocking call, and count the time that it takes."""
        begun_ns = self._clock()
        result = wait(receive)
        self._waited_ns += self._clock() - begun_ns
        return result

    def came(self, vehicle: int) -> None:
        """Note a message of a vehicle that the step needs."""
        self._last_ns[self.hosts.get(vehicle, "")] = self._waited_ns

    def ended(self) -> Late | None:
        """Return the latecomer of the step that ends here; None if there are not two machines."""
        last_ns, self._last_ns, self._waited_ns = self._last_ns, {}, 0
        machines = {*self.hosts.values(), *last_ns}
        if len(machines) < 2:
            return None
        *_, before, last = sorted((last_ns.get(host, 0), host) for host in machines)
        return Late(last[1], last[0] - before[0]) if last[1] else None
