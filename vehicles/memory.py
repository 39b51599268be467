"""The state that a law keeps from one decision to the next."""

from __future__ import annotations

from zenvoy.vehicles.decision import Controller


class Memory:
    """The state of the law that decided last; a law that takes over starts anew."""

    def __init__(self) -> None:
        self._controller: Controller | None = None
        self._cycle = -1
        self._state: tuple[float, ...] | None = None

    def recalled(self, controller: Controller, cycle: int) -> tuple[float, ...] | None:
        """Return the state of a law if it decided in the cycle before; None if it starts."""
        if controller is not self._controller or cycle != self._cycle + 1:
            return None
        return self._state

    def keep(self, controller: Controller, cycle: int, state: tuple[float, ...] | None) -> None:
        """Keep the state that the law returned; None if it did not decide."""
        self._controller, self._cycle, self._state = controller, cycle, state
