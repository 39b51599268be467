"""`zenvoy certs`: make a test authority, and the certificates of a fleet."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Final

import typer

from zenvoy.cli.terminal import refuse, say

_HOST: Final = re.compile(r"[0-9A-Za-z]([\w.:-]{0,251}[0-9A-Za-z])?|::1", re.ASCII)
_GROUP: Final = re.compile(r"([1-9][0-9]{0,3})-([1-9][0-9]{0,3})", re.ASCII)


def certs(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of the authority; made if it is missing.")
    ],
    vehicles: Annotated[
        int, typer.Option(min=1, max=9_999, help="Number of vehicles: 1, 2, and so on.")
    ] = 40,
    groups: Annotated[
        list[str] | None,
        typer.Option(
            "--group", metavar="N-M", help="Vehicles of one host, for zenvoy join; repeatable."
        ),
    ] = None,
    hosts: Annotated[
        list[str] | None,
        typer.Option(
            "--host",
            metavar="HOST",
            help="A name or address by which others reach world and channel, besides those of "
            "this machine; repeatable.",
        ),
    ] = None,
    router: Annotated[
        str | None,
        typer.Option(
            metavar="tls/HOST:PORT",
            help="Also make router.json5 and a certificate for a Zenoh router that listens there.",
        ),
    ] = None,
    per_process: Annotated[
        int,
        typer.Option(
            "--vehicles-per-process", min=1, help="Through that router: vehicles in a process."
        ),
    ] = 1,
    days: Annotated[int, typer.Option(min=1, max=3_650, help="Days of validity.")] = 365,
) -> None:
    """Make a test authority, and a certificate per role and vehicle.

    Certificates that are there are kept, and only missing ones are made. To revoke one, remove its
    line from members.txt.
    """
    from zenvoy.fleet.authority import make_certificates, validity_of
    from zenvoy.fleet.certificates import MEMBERS, CertificatesError
    from zenvoy.fleet.guests import GuestsError, address_of
    from zenvoy.fleet.hosts import hosts_here
    from zenvoy.fleet.routers import write_router

    for host in hosts or ():
        if _HOST.fullmatch(host) is None:
            refuse(f"--host {host}: is not the name or the address of a host")
    try:
        if router is not None and address_of(router, "--router")[0] != "tls":
            refuse(f"--router {router}: is not tls/HOST:PORT; its rules are for certificates")
    except GuestsError as error:
        refuse(str(error))
    names = ["world", "channel", "observer", *([] if router is None else ["router"])]
    names += [f"vehicle-{vehicle}" for vehicle in range(1, vehicles + 1)]
    for group in groups or ():
        names.append(f"vehicles-{_checked(group)}")
    validity = validity_of(days)
    reached = list(dict.fromkeys([*hosts_here(), *(hosts or ())]))
    try:
        made = make_certificates(folder, names, reached, validity)
        config = None if router is None else write_router(folder, router, vehicles, per_process)
    except CertificatesError as error:
        refuse(str(error))
    except OSError as error:
        refuse(f"{folder}: {error.strerror}")
    if config is not None:
        say(f"{config} is for Zenoh's router: zenohd -c {config.name}, in {folder}")
    if not made:
        say(f"{folder} has all of these already")
        return
    until = f"valid to {validity.end:%Y-%m-%d}"
    say(f"{len(made)} certificates in {folder}, {until}; {MEMBERS} lists who may enter")
    if any(member.role in ("world", "router") for member in made):
        say(f"{'router' if router else 'world and channel'} are {', '.join(reached)}")
    opened = "--listen tls/0.0.0.0:7447" if router is None else "--router tls/HOST:PORT"
    say(f"here: zenvoy run SCENARIO {opened} --certs {folder}")
    drivers = [member.name for member in made if member.role == "vehicle"]
    if drivers:
        say(
            f"a vehicle elsewhere needs authority.pem and its own two files, as {drivers[-1]}.*; "
            "authority.key stays here"
        )


def _checked(group: str) -> str:
    """Return the name of a group of vehicles; if it is none, print why and exit."""
    found = _GROUP.fullmatch(group)
    if found is None or int(found[1]) >= int(found[2]):
        refuse(f"--group {group}: is not N-M with 1 <= N < M <= 9999, as 21-40")
    return group
