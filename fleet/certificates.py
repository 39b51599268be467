"""A folder of certificates: who may enter, and the files of each."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from zenvoy.bus.access import Member, member_of
from zenvoy.bus.doors import Doors, Identity
from zenvoy.bus.vehicle_processes import VehicleProcess

AUTHORITY: Final = "authority.pem"
MEMBERS: Final = "members.txt"
_MAX_CHARACTERS: Final = 4_000_000


class CertificatesError(Exception):
    """A folder of certificates cannot be made or used; the text says why in a line."""


def members_in(folder: Path) -> tuple[Member, ...]:
    """Return who may enter, from the list in the folder; raises CertificatesError."""
    path = folder / MEMBERS
    try:
        with path.open(encoding="utf-8") as file:
            lines = file.read(_MAX_CHARACTERS).splitlines()
    except FileNotFoundError as error:
        raise CertificatesError(f"{path}: is missing; zenvoy certs {folder} makes it") from error
    except (OSError, UnicodeDecodeError) as error:
        raise CertificatesError(f"{path}: cannot be read: {error}") from error
    found: dict[str, Member] = {}
    for number, line in enumerate(lines, 1):
        name = line.partition("#")[0].strip()
        if not name:
            continue
        try:
            member = member_of(name)
        except ValueError as error:
            raise CertificatesError(f"{path}, line {number}: {error}") from error
        if name in found:
            raise CertificatesError(f"{path}, line {number}: {name} is listed twice")
        found[name] = member
    return tuple(found.values())


def certificate_of(process: VehicleProcess) -> str:
    """Return the name of the certificate that the process of vehicles needs."""
    first, last = process.vehicles[0], process.vehicles[-1]
    return f"vehicles-{first}-{last}" if process.is_shared else f"vehicle-{first}"


def doors_of(folder: Path, name: str) -> Doors:
    """Return the doors of the process with this certificate; raises CertificatesError."""
    identity = Identity(
        authority=folder / AUTHORITY,
        certificate=folder / f"{name}.pem",
        key=folder / f"{name}.key",
    )
    for path in (identity.authority, identity.certificate, identity.key):
        try:
            with path.open("rb"):
                pass
        except FileNotFoundError as error:
            raise CertificatesError(
                f"--certs {folder}: has no {path.name}; zenvoy certs makes it"
            ) from error
        except OSError as error:
            raise CertificatesError(f"--certs {folder}: {path.name}: {error.strerror}") from error
    return Doors(identity=identity)
