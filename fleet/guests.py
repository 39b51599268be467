"""Guests: vehicles that a run leaves to other programs, and the endpoints for these.

No endpoint beyond this machine is open without TLS, unless the user insists.
"""

from __future__ import annotations

import ipaddress
import json
import re
import socket
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Final

from pydantic import AfterValidator, Field, StringConstraints, TypeAdapter, ValidationError

from zenvoy.bus.topics import plain_name
from zenvoy.fleet.hosts import hosts_here
from zenvoy.fleet.process_id import ProcessId
from zenvoy.scenarios import ProcessFrozen, ProcessKilled, Scenario, all_faults

FILE: Final = "connect.json"
_TLS: Final = "tls/"
_EVERYWHERE: Final = ("0.0.0.0", "::")  # all addresses of this machine
_MAX_BYTES: Final = 65_536
# Excludes `?` and `#`, which end the address in a Zenoh endpoint.
_ENDPOINT: Final = re.compile(
    r"(?P<protocol>tcp|tls)/(\[(?P<six>[0-9A-Fa-f:.]+)\]|(?P<host>[\w.-]+)):(?P<port>[0-9]{1,5})",
    re.ASCII,
)
Endpoint = Annotated[str, StringConstraints(min_length=1, max_length=1_000)]


class GuestsError(Exception):
    """A request for guests cannot be met; the text says why in a line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Guests:
    """The vehicles that a run starts without, and endpoints besides the Unix sockets.

    The world listens at each `tls/<host>:<port>` or `tcp/<host>:<port>` of `listen`, the channel on
    the next port. `certs` is the folder of the certificates for TLS. With a `router`, nobody
    listens: all processes connect to this endpoint of a Zenoh router.
    """

    without: frozenset[int] = frozenset()
    listen: tuple[str, ...] = ()
    certs: Path | None = None
    router: str | None = None
    all_elsewhere: bool = False  # whether other machines run all vehicles, in their processes


NO_GUESTS: Final = Guests()


@dataclass(frozen=True, slots=True, kw_only=True)
class RunEndpoints:
    """The name of a run, and the endpoints of its world and of its channel.

    Both may be those of a Zenoh router. `command` is the process of `zenvoy run`, where it is
    known.
    """

    run: Annotated[str, AfterValidator(plain_name)]
    world: Annotated[tuple[Endpoint, ...], Field(min_length=1)]
    channel: Annotated[tuple[Endpoint, ...], Field(min_length=1)]
    router: bool = False
    command: ProcessId | None = None

    def write(self, folder: Path) -> None:
        """Write them to a file in the folder of the run; it is whole as soon as it is there."""
        partial = folder / f"{FILE}.part"
        partial.write_text(json.dumps(asdict(self), indent=2) + "\n", encoding="utf-8")
        partial.replace(folder / FILE)

    @property
    def connect(self) -> tuple[str, ...]:
        """The endpoint of the world and that of the channel to connect to on this machine."""
        return tuple(dict.fromkeys((self.world[0], self.channel[0])))


def require_no_faults(without: Iterable[int], scenario: Scenario) -> None:
    """Raise GuestsError if the scenario kills or freezes the process of a guest.

    Only a run's own processes fail on purpose.
    """
    for vehicle in without:
        for index, fault, vehicles in all_faults(scenario):
            if isinstance(fault, ProcessKilled | ProcessFrozen) and vehicle in vehicles:
                raise GuestsError(
                    f"--without {vehicle}: faults.{index} ({fault.type}) is of its process; "
                    "allowed: vehicles without faults of processes"
                )


def guests(
    without: Sequence[int],
    listen: Sequence[str],
    size: int,
    certs: Path | None = None,
    *,
    insecure: bool = False,
    router: str | None = None,
) -> Guests:
    """Return the guests of a fleet of `size`; raises GuestsError for a bad vehicle or endpoint.

    An endpoint beyond this machine needs TLS, whose certificates are in `certs`, or `insecure`.
    With a router, nobody may listen.
    """
    if router is not None and listen:
        raise GuestsError(
            f"--listen {listen[0]}: with --router nobody listens; allowed: one of them"
        )
    for vehicle in without:
        if not 1 <= vehicle <= size:
            raise GuestsError(
                f"--without {vehicle}: is not in [1, {size}], the vehicles of fleet.size ({size})"
            )
    for endpoint in listen:
        _require_lock("--listen", endpoint, certs, insecure)
    if router is not None:
        _require_lock("--router", router, certs, insecure)
    opened = [*listen, *([] if router is None else [router])]
    if certs is not None and not any(endpoint.startswith(_TLS) for endpoint in opened):
        raise GuestsError(f"--certs {certs}: needs an endpoint with TLS, as --listen tls/HOST:PORT")
    with ExitStack() as held:  # hold all ports at once, so that none is taken twice
        for endpoint in listen:
            _, host, port = address_of(endpoint)
            for number in (port, port + 1):
                try:
                    held.enter_context(socket.create_server((host, number), family=_family(host)))
                except OSError as error:
                    why = error.strerror or str(error)
                    raise GuestsError(f"--listen {endpoint}: port {number}: {why}") from error
    return Guests(without=frozenset(without), listen=tuple(listen), certs=certs, router=router)


def open_to_all(listen: Sequence[str]) -> list[str]:
    """Return the endpoints beyond this machine to which any program can connect."""
    return [one for one in listen if not one.startswith(_TLS) and not _is_here(address_of(one)[1])]


def endpoints_of(
    run: str, sockets: Path, listen: Sequence[str], router: str | None = None
) -> RunEndpoints:
    """Return the endpoints of a run of this process.

    These are Unix sockets in a folder, and `listen`; or that of a router alone.
    """
    if router is not None:
        own = ProcessId.own()
        return RunEndpoints(run=run, command=own, world=(router,), channel=(router,), router=True)
    addresses = [address_of(endpoint) for endpoint in listen]
    return RunEndpoints(
        run=run,
        command=ProcessId.own(),
        world=(f"unixsock-stream/{sockets / 'world'}", *listen),
        channel=(
            f"unixsock-stream/{sockets / 'channel'}",
            *(f"{protocol}/{_bracketed(host)}:{port + 1}" for protocol, host, port in addresses),
        ),
    )


def from_elsewhere(endpoints: RunEndpoints) -> tuple[str, ...]:
    """Return an endpoint of the world and one of the channel by which other machines connect."""
    if endpoints.router:
        return endpoints.connect
    found = []
    for several in (endpoints.world, endpoints.channel):
        protocol, host, port = address_of(several[-1])
        if host in _EVERYWHERE:
            host = hosts_here()[-1]
        found.append(f"{protocol}/{_bracketed(host)}:{port}")
    return tuple(found)


def read_endpoints(folder: Path) -> RunEndpoints:
    """Read the endpoints of a run under way from its folder; raises GuestsError."""
    path = folder / FILE
    if not path.is_file():
        raise GuestsError(
            f"--run {folder}: has no {FILE}; name the folder of a run under way, or use --connect"
        )
    try:
        with path.open("rb") as file:
            endpoints = _ENDPOINTS.validate_json(file.read(_MAX_BYTES))
    except OSError as error:
        raise GuestsError(f"--run {folder}: {FILE}: {error.strerror}") from error
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        what = ": ".join((*(str(part) for part in first["loc"]), first["msg"]))
        raise GuestsError(f"--run {folder}: {FILE} is not valid: {what}") from error
    if endpoints.command is not None and endpoints.command.has_ended:
        raise GuestsError(f"--run {folder}: the run was killed, and has left {FILE} behind")
    return endpoints


def _require_lock(option: str, endpoint: str, certs: Path | None, insecure: bool) -> None:
    """Raise GuestsError for an endpoint that anybody on the network could use unasked."""
    protocol, host, _ = address_of(endpoint, option)
    if protocol == "tls" and certs is None:
        raise GuestsError(
            f"{option} {endpoint}: needs --certs DIR, a folder that zenvoy certs makes"
        )
    if protocol == "tcp" and not insecure and not _is_here(host):
        raise GuestsError(
            f"{option} {endpoint}: lets anybody on the network in; allowed: tls/{_bracketed(host)} "
            "with --certs DIR, tcp/127.0.0.1, or --insecure"
        )


def _is_here(host: str) -> bool:
    """Return whether only this machine reaches that host."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def address_of(endpoint: str, option: str = "--listen") -> tuple[str, str, int]:
    """Return the protocol, host and port of a TCP or TLS endpoint; raises GuestsError."""
    found = _ENDPOINT.fullmatch(endpoint)
    if found is None or not 1 <= int(found["port"]) < 65_535:
        raise GuestsError(
            f"{option} {endpoint}: is not tls/<host>:<port> or tcp/<host>:<port> with a port in "
            "[1, 65534]; an IPv6 address stands in brackets"
        )
    return found["protocol"], found["six"] or found["host"], int(found["port"])


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET


_ENDPOINTS: Final = TypeAdapter(RunEndpoints)
