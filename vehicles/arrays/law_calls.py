"""Calls the laws for many vehicles at once, and keeps the states of each law."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from typing import Any, NamedTuple

import numpy as np

from zenvoy.laws import Observation, Output
from zenvoy.laws.errors import LawError, described
from zenvoy.vehicles.arrays.refusal import NotCoveredError
from zenvoy.vehicles.arrays.rows import Floats, Ints, Rows, anywhere, everywhere
from zenvoy.vehicles.arrays.strict import strict_arithmetic
from zenvoy.vehicles.decision import Controller, applied
from zenvoy.vehicles.time_limit import time_limit


class _State(NamedTuple):
    """The state of a law for every vehicle, and the cycle of its last decision for each."""

    cycle: Ints
    columns: tuple[Floats, ...]


class LawCalls:
    """Calls laws for `count` vehicles, in runs of vehicles with these names, and keeps states."""

    def __init__(self, count: int, names: Sequence[str]) -> None:
        self._count, self._names = count, names
        self._states: dict[int, _State] = {}  # by identity of the controller

    def call(
        self, cycle: int, controller: Controller, rows: Rows, observation: Observation
    ) -> Output:
        """Return the output of a law for some vehicles in a cycle; the observation gets its state.

        Raises LawError with the name of the first vehicle for which the law fails by itself, and
        NotCoveredError if it fails only for all of them at once.
        """
        if controller.law.state:
            state = self._recalled(cycle, controller, rows)
            observation = observation._replace(state=state)
        output = self._output(controller, rows, observation)
        if output.state:
            self._keep(cycle, controller, rows, output.state)
        return output

    def _output(self, controller: Controller, rows: Rows, observation: Observation) -> Output:
        law, limit_s = controller.law, controller.limit_s
        strict = nullcontext() if limit_s is None else strict_arithmetic()
        try:
            with time_limit(limit_s), strict:
                returned = law.acceleration(observation, controller.parameters)
            output = returned if isinstance(returned, Output) else Output(returned)
            if _usable(output, len(law.columns)):
                return output
        except BaseException as error:  # the law may raise anything, even by sys.exit
            self._blame(controller, rows, observation)
            what = f"law {law.name} raised {described(error)}, but only on arrays"
            raise NotCoveredError(what) from error
        self._blame(controller, rows, observation)
        raise NotCoveredError(f"law {law.name} gives other values on arrays than on floats")

    def _blame(self, controller: Controller, rows: Rows, observation: Observation) -> None:
        """Raise LawError for the first vehicle on which the law fails."""
        for at, member in enumerate(np.arange(self._count)[rows].tolist()):
            try:
                applied(controller, _alone(observation, at))
            except LawError as error:
                error.process = self._names[member % len(self._names)]
                raise

    def _recalled(self, cycle: int, controller: Controller, rows: Rows) -> tuple[Floats, ...]:
        """Return the states of a law, which are new where it did not decide in the last cycle."""
        start = tuple(np.full(self._count, value) for value in controller.law.state)
        kept = self._states.get(id(controller))
        if kept is None:
            return tuple(column[rows] for column in start)
        goes_on = kept.cycle == cycle - 1
        return tuple(
            np.where(goes_on, value, first)[rows]
            for value, first in zip(kept.columns, start, strict=True)
        )

    def _keep(
        self, cycle: int, controller: Controller, rows: Rows, state: tuple[Floats, ...]
    ) -> None:
        kept = self._states.get(id(controller))
        if kept is None:
            never = np.full(self._count, -2, dtype=np.int64)
            kept = _State(never, tuple(np.zeros(self._count) for _ in state))
            self._states[id(controller)] = kept
        kept.cycle[rows] = cycle
        for column, values in zip(kept.columns, state, strict=True):
            column[rows] = values


def _usable(output: Output, columns: int) -> bool:
    """Return whether an output is valid for every vehicle, by the rules of `decision.applied`."""
    numbers = (output.acceleration, *output.state)
    return (
        all(everywhere(np.isfinite(values)) for values in numbers)
        and len(output.logged) == columns
        and not any(anywhere(np.isinf(values)) for values in output.logged)
    )


def _alone(observation: Observation, at: int) -> Observation:
    """Return the observation of one vehicle, in floats."""

    def one(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return float(value[at])
        if isinstance(value, tuple):
            parts = [one(part) for part in value]
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        return value

    def uniform(number: int) -> float:
        return float(observation.uniform(number)[at])

    seen: Observation = one(observation)
    return seen._replace(uniform=uniform)
