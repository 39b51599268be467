"""`zenvoy vehicle`: one vehicle, from a process of its own, in a run that is under way."""

from __future__ import annotations

import signal
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import zenoh
from pydantic import ValidationError
from rich.console import Console
from setproctitle import setproctitle

from zenvoy.bus.connection import Wiring
from zenvoy.bus.errors import BusError, NoAnswerError, StalledError, StoppedError
from zenvoy.bus.joining import ask, at_end
from zenvoy.bus.session import prefer_latency, prefer_throughput
from zenvoy.bus.topics import plain_name, vehicle_name
from zenvoy.cli.guests import GuestsError, read_meeting
from zenvoy.cli.terminal import EXIT_BAD_INPUT, EXIT_INTERRUPTED, EXIT_PROCESS_LOST, requests_to_end
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.knowledge import prepare
from zenvoy.vehicles.process import run_vehicle

_SHORTEST_S: Final = 0.1
_LONGEST_S: Final = 86_400


class JoinError(Exception):
    """The vehicle cannot join; the text says why in a line."""


def join(
    vehicle: int,
    run: str,
    connect: Sequence[str],
    limit_s: float,
    console: Console,
    errors: Console,
) -> int:
    """Join, and drive the vehicle to the end of the run; the exit code of the command.

    The session may still be open afterwards, for closing it may wait for a peer that is frozen.
    """
    if not _SHORTEST_S <= limit_s <= _LONGEST_S:  # NaN is neither below nor above
        errors.print(f"--timeout-s {limit_s:g}: is not in [{_SHORTEST_S}, {_LONGEST_S}]")
        return EXIT_BAD_INPUT
    try:
        run, endpoints = _where(run, connect)
        scenario = _scenario(vehicle, run, endpoints, limit_s)
    except (JoinError, GuestsError, NoAnswerError) as error:
        errors.print(str(error))
        return EXIT_BAD_INPUT
    return _Drive(scenario, vehicle, run, endpoints).to_the_end(console, errors)


def _where(run: str, connect: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    if connect:
        try:
            return plain_name(run), tuple(connect)
        except ValueError as error:
            raise JoinError(f"--run: {error}") from error
    meeting = read_meeting(Path(run))
    return meeting.run, meeting.connect


def _scenario(vehicle: int, run: str, connect: Sequence[str], limit_s: float) -> Scenario:
    """What the world says of the run, if there is a place for the vehicle; raises JoinError."""
    try:
        standing = ask(run, connect, limit_s)
    except NoAnswerError as error:
        raise JoinError(f"--run {run}: {error}") from error
    try:
        scenario = Scenario.model_validate_json(standing.scenario)
    except ValidationError as error:
        raise JoinError(f"--run {run}: its scenario is of another version of Zenvoy") from error
    size = scenario.fleet.size
    if not 1 <= vehicle <= size:
        raise JoinError(f"--id {vehicle}: is not in [1, {size}], the vehicles of the run")
    name = vehicle_name(vehicle, size)
    if name in standing.present:
        raise JoinError(f"--id {vehicle}: {name} is there already")
    for process, vehicles in standing.shared.items():
        if vehicle in vehicles:
            raise JoinError(
                f"--id {vehicle}: shares the process {process}, which it cannot leave; "
                f"allowed: a vehicle that the run was started --without, or that is a process"
            )
    return scenario


class _Drive:
    """A vehicle that is about to join, or has; told of requests to end, and of the run's end."""

    def __init__(
        self, scenario: Scenario, vehicle: int, run: str, connect: tuple[str, ...]
    ) -> None:
        self._scenario, self._vehicle = scenario, vehicle
        self._name = vehicle_name(vehicle, scenario.fleet.size)
        self._wiring = Wiring(
            run=run,
            vehicles=range(1, scenario.fleet.size + 1),
            connect=connect,
            stall_limit_s=scenario.stall_limit_s,
        )
        self._joined = self._ended = False
        self._watched: object = None

    def to_the_end(self, console: Console, errors: Console) -> int:
        """Drive, and say how it ended; the exit code."""

        def on_joined(session: zenoh.Session) -> None:
            self._joined = True
            self._watched = at_end(session, self._wiring.run, self._end)
            console.print(f"{self._name} has joined {self._wiring.run}", highlight=False)

        prepare(self._scenario)
        (prefer_latency if self._scenario.clock == "realtime" else prefer_throughput)()
        setproctitle(f"zenvoy {self._name} {self._wiring.run}")
        for number in requests_to_end():
            if number != signal.SIGTERM:  # the bus takes that one itself
                signal.signal(number, lambda *_: _ask_to_end())
        try:
            run_vehicle(self._scenario, self._vehicle, self._wiring, on_joined)
        except StoppedError:
            if not self._ended:
                return EXIT_INTERRUPTED
        except StalledError as error:
            errors.print(f"{self._name}: {error}{'' if self._joined else _HINT}")
            return EXIT_PROCESS_LOST if self._joined else EXIT_BAD_INPUT
        except BusError as error:
            errors.print(f"{self._name}: {error}")
            return EXIT_PROCESS_LOST
        console.print("the run has ended")
        return 0

    def _end(self) -> None:
        self._ended = True
        _ask_to_end()


_HINT = "; --connect takes an endpoint of the world and one of the channel"


def _ask_to_end() -> None:
    """What the bus takes as a request to end; it leaves at the next wait."""
    signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)
