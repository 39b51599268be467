"""Drives one vehicle of a run that is under way, in this process."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import zenoh
from pydantic import ValidationError
from setproctitle import setproctitle

from zenvoy.bus.doors import Doors
from zenvoy.bus.errors import NoAnswerError, StoppedError
from zenvoy.bus.joining import RunState, ask, at_end
from zenvoy.bus.topics import plain_name, vehicle_name
from zenvoy.bus.wiring import Wiring
from zenvoy.fleet.certificates import doors_of
from zenvoy.fleet.guests import read_endpoints
from zenvoy.fleet.priority import prefer_latency, prefer_throughput
from zenvoy.fleet.requests import requests_to_end
from zenvoy.laws.by_name import ESTIMATORS, LAWS, resolve
from zenvoy.laws.errors import UnknownLawError
from zenvoy.scenarios import Scenario, modes
from zenvoy.vehicles.preparation import prepare
from zenvoy.vehicles.process import run_vehicle


class JoinError(Exception):
    """The vehicle cannot join; the text says why in a line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Vacancy:
    """A vehicle that is missing in a run, and the endpoints of the run."""

    vehicle: int
    run: str
    connect: tuple[str, ...]
    scenario: Scenario
    doors: Doors | None = None
    router: bool = False  # whether `connect` is a Zenoh router

    @property
    def name(self) -> str:
        """The name of the vehicle's process."""
        return vehicle_name(self.vehicle, self.scenario.fleet.size)


def find(
    vehicle: int,
    run: str,
    connect: Sequence[str],
    limit_s: float,
    certs: Path | None = None,
    *,
    router: bool = False,
    allow_code: bool = False,
) -> Vacancy:
    """Ask a run for its scenario, and check that a vehicle is missing in it.

    `run` is the folder of the run, or its name if `connect` gives its endpoints, or the endpoint of
    its router. `certs` is a folder with the certificate of the vehicle. Raises JoinError,
    GuestsError, CertificatesError, or NoAnswerError if nobody answers within `limit_s`.
    """
    run, endpoints, router = _name_and_endpoints(run, connect, router)
    doors = None if certs is None else doors_of(certs, f"vehicle-{vehicle}")
    try:
        state = ask(run, endpoints, limit_s, doors, router=router)
    except NoAnswerError as error:
        raise JoinError(f"--run {run}: {error}") from error
    scenario = _scenario(vehicle, run, state)
    load_code(scenario, allow_code)
    return Vacancy(
        vehicle=vehicle,
        run=run,
        connect=endpoints,
        scenario=scenario,
        doors=doors,
        router=router,
    )


def _name_and_endpoints(
    run: str, connect: Sequence[str], router: bool
) -> tuple[str, tuple[str, ...], bool]:
    if connect:
        try:
            return plain_name(run), tuple(connect), router
        except ValueError as error:
            raise JoinError(f"--run: {error}") from error
    endpoints = read_endpoints(Path(run))
    return endpoints.run, endpoints.connect, endpoints.router


def _scenario(vehicle: int, run: str, state: RunState) -> Scenario:
    """Return the scenario of the run; raises JoinError if the vehicle cannot join it."""
    try:
        scenario = Scenario.model_validate_json(state.scenario)
    except ValidationError as error:
        raise JoinError(f"--run {run}: its scenario is from another version of Zenvoy") from error
    size = scenario.fleet.size
    if not 1 <= vehicle <= size:
        raise JoinError(f"--id {vehicle}: is not in [1, {size}], the vehicles of the run")
    name = vehicle_name(vehicle, size)
    if name in state.present:
        raise JoinError(f"--id {vehicle}: {name} is in the run already")
    for process, vehicles in state.shared.items():
        if vehicle in vehicles:
            raise JoinError(
                f"--id {vehicle}: shares the process {process}, which it cannot leave; "
                f"allowed: a vehicle that has a process of its own, or that --without left out"
            )
    return scenario


def load_code(scenario: Scenario, allow_code: bool) -> None:
    """Load the scenario's own code from installed packages or from files in this folder.

    A run must not choose which files of this folder are executed, so files need `allow_code`.
    """
    named = [("law", model, LAWS) for model in modes(scenario)]
    named.append(("estimator", scenario.estimator.kind, ESTIMATORS))
    for what, reference, kind in named:
        try:
            resolve(reference, Path() if allow_code else None, kind, allow_code=allow_code)
        except UnknownLawError as error:
            hint = "" if allow_code else "; --allow-code looks in this folder"
            raise JoinError(f"{what} {reference}: {error}{hint}") from error


class Guest:
    """Drives the vehicle of a vacancy; use it once, in a process of its own.

    `joined` says whether the vehicle has joined the run. The session may still be open afterwards,
    because closing it may wait for a frozen peer.
    """

    def __init__(self, vacancy: Vacancy) -> None:
        self._vacancy = vacancy
        self.joined = self._ended = False
        self._watched: object = None

    def drive(self, on_joined: Callable[[], None]) -> None:
        """Join and drive to the end of the run; raises BusError, StoppedError if asked to end."""
        vacancy, scenario = self._vacancy, self._vacancy.scenario
        wiring = Wiring(
            run=vacancy.run,
            vehicles=range(1, scenario.fleet.size + 1),
            connect=vacancy.connect,
            stall_limit_s=scenario.stall_limit_s,
            doors=vacancy.doors,
            router=vacancy.router,
        )

        def begin(session: zenoh.Session) -> None:
            self.joined = True
            self._watched = at_end(session, vacancy.run, self._end)
            on_joined()

        prepare(scenario)
        (prefer_latency if scenario.clock == "realtime" else prefer_throughput)()
        setproctitle(f"zenvoy {vacancy.name} {vacancy.run}")
        for number in requests_to_end():
            if number != signal.SIGTERM:  # the bus handles that one itself
                signal.signal(number, lambda *_: ask_to_end())
        try:
            run_vehicle(scenario, vacancy.vehicle, wiring, begin)
        except StoppedError:
            if not self._ended:
                raise

    def _end(self) -> None:
        self._ended = True
        ask_to_end()


def ask_to_end() -> None:
    """Send this process SIGTERM, which ends the bus at its next wait."""
    signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)
