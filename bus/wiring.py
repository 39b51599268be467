"""What a process knows of its run before it connects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from zenvoy.bus.doors import Doors
from zenvoy.bus.vehicle_processes import VehicleProcess


@dataclass(frozen=True, slots=True, kw_only=True)
class Wiring:
    """The run and fleet of a process, its endpoints, and the processes that it waits for."""

    run: str
    vehicles: Sequence[int]
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()
    waits_for: tuple[str, ...] = ()  # processes that must be ready before this one is
    stall_limit_s: float | None = None
    absent: frozenset[int] = frozenset()  # vehicles that may join later; nobody waits for them
    shared_processes: tuple[VehicleProcess, ...] = ()  # processes that run several vehicles each
    doors: Doors | None = None  # for TLS endpoints
    public: frozenset[str] = frozenset()  # names of the streams that observers may read
    router: bool = False  # whether it connects to a Zenoh router, and nobody listens
    patient: bool = False  # whether it waits for the others without a limit before it begins
    far: bool = False  # whether the world runs on another machine, with another clock
    clock_error_ns: int = 0  # in real time: how far the clocks of other machines may be off
