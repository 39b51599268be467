"""`zenvoy vehicle`: drive one vehicle of a run that is under way."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rich.console import Console

from zenvoy.bus.errors import BusError, NoAnswerError, StalledError, StoppedError
from zenvoy.cli import exits
from zenvoy.fleet.certificates import CertificatesError
from zenvoy.fleet.guests import GuestsError
from zenvoy.fleet.join import Guest, JoinError, Vacancy, find
from zenvoy.laws.errors import LawError

_SHORTEST_S: Final = 0.1
_LONGEST_S: Final = 86_400
_HINT: Final = "; --connect needs an endpoint of the world and one of the channel"


def join(
    vehicle: int,
    run: str,
    connect: Sequence[str],
    limit_s: float,
    console: Console,
    errors: Console,
    certs: Path | None = None,
    *,
    router: bool = False,
    allow_code: bool = False,
) -> int:
    """Join a run, and drive the vehicle to its end; return the exit code."""
    if not _SHORTEST_S <= limit_s <= _LONGEST_S:  # this refuses NaN, too
        errors.print(f"--timeout-s {limit_s:g}: is not in [{_SHORTEST_S}, {_LONGEST_S}]")
        return exits.BAD_INPUT
    try:
        vacancy = find(vehicle, run, connect, limit_s, certs, router=router, allow_code=allow_code)
    except (JoinError, GuestsError, NoAnswerError, CertificatesError) as error:
        errors.print(str(error))
        return exits.BAD_INPUT
    return _drive(vacancy, console, errors)


def _drive(vacancy: Vacancy, console: Console, errors: Console) -> int:
    """Drive the vehicle, and print how that ended; return the exit code."""

    def on_joined() -> None:
        console.print(f"{vacancy.name} has joined {vacancy.run}", highlight=False)

    guest = Guest(vacancy)
    try:
        guest.drive(on_joined)
    except StoppedError:
        return exits.INTERRUPTED
    except StalledError as error:
        errors.print(f"{vacancy.name}: {error}{'' if guest.joined else _HINT}")
        return exits.PROCESS_LOST if guest.joined else exits.BAD_INPUT
    except (BusError, LawError) as error:
        errors.print(f"{vacancy.name}: {error}")
        return exits.PROCESS_LOST
    console.print("the run has ended")
    return exits.OK
