"""Opens a run to other programs and machines, or refuses to, in a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from zenvoy.bus.doors import Doors
from zenvoy.bus.vehicle_processes import VehicleProcess, vehicle_processes
from zenvoy.cli.terminal import errors, refuse
from zenvoy.fleet.asking import fault_of_router
from zenvoy.fleet.certificates import CertificatesError, certificate_of, doors_of, members_in
from zenvoy.fleet.guests import Guests, GuestsError, guests, open_to_all, require_no_faults
from zenvoy.scenarios import Scenario


def _doors(certs: Path | None, processes: Sequence[VehicleProcess]) -> Doors | None:
    """Return the doors of the world; raises CertificatesError if a certificate is missing."""
    if certs is None:
        return None
    for name in ("channel", *map(certificate_of, processes)):
        doors_of(certs, name)
    members_in(certs)
    return doors_of(certs, "world")


def guests_of(
    without: Sequence[int],
    listen: Sequence[str],
    scenario: Scenario,
    certs: Path | None,
    *,
    insecure: bool,
    router: str | None = None,
    per_process: int = 1,
    all_elsewhere: bool = False,
) -> Guests:
    """Return the guests of a run; print what is wrong and exit, or warn of open doors.

    A router must be there, and let the world in.
    """
    try:
        size = scenario.fleet.size
        require_no_faults(range(1, size + 1) if all_elsewhere else without, scenario)
        found = guests(without, listen, size, certs, insecure=insecure, router=router)
        here = () if all_elsewhere else vehicle_processes(size, per_process, found.without)
        doors = _doors(certs, () if router is None else here)
        if router is not None and (fault := fault_of_router(router, doors)):
            refuse(f"--router: {fault}")
    except (GuestsError, CertificatesError) as error:
        text = str(error)
        refuse(text.replace("--without", "vehicle", 1) if all_elsewhere else text)
    for endpoint in open_to_all([*found.listen, *([] if router is None else [router])]):
        errors.print(
            f"warning: {endpoint} is open to anybody on the network, who can read all senses and "
            "command all vehicles"
        )
    return replace(found, all_elsewhere=all_elsewhere)
