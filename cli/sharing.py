"""`zenvoy join`: drive a share of the vehicles of a run, to its exit code."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from zenvoy.cli import exits
from zenvoy.fleet.certificates import CertificatesError
from zenvoy.fleet.ends import Death, shortage_of
from zenvoy.fleet.folder import LOGS, FolderError, make_folder
from zenvoy.fleet.interruption import Interrupted
from zenvoy.fleet.join import JoinError
from zenvoy.fleet.share import Share, find_share, run_share
from zenvoy.values.wording import spans


def join_share(
    vehicles: range,
    run: str | None,
    connect: Sequence[str],
    limit_s: float,
    certs: Path | None,
    console: Console,
    errors: Console,
    *,
    out: Path | None,
    per_process: int | None,
    host: str | None,
    router: bool,
    allow_code: bool,
) -> int:
    """Join a run with some vehicles, and drive them to its end; return the exit code.

    Without a name of the run, join the only one there is.
    """
    try:
        share = find_share(
            vehicles,
            run,
            connect,
            limit_s,
            certs,
            per_process=per_process,
            host=host,
            router=router,
            allow_code=allow_code,
        )
        folder = make_folder(out, f"join-{vehicles[0]}-{vehicles[-1]}")
    except (JoinError, CertificatesError) as error:
        errors.print(str(error))
        return exits.BAD_INPUT
    except FolderError as error:
        errors.print(f"--out {error}")
        return exits.BAD_INPUT
    return _drive(share, vehicles, folder, console, errors)


def _drive(share: Share, vehicles: range, folder: Path, console: Console, errors: Console) -> int:
    count = len(share.processes)
    processes = "1 process" if count == 1 else f"{count} processes"
    what = f"vehicles {spans(vehicles)} in {processes}"

    def on_started() -> None:
        console.print(f"{what} are joining {share.run}", highlight=False, soft_wrap=True)

    lost: list[Death] = []

    def on_loss(death: Death) -> None:
        lost.append(death)
        _print_death(death, errors)

    try:
        death = run_share(share, folder / LOGS, on_started, on_loss)
    except Interrupted:
        return exits.INTERRUPTED
    except OSError as error:
        errors.print(f"the vehicles cannot go on: {shortage_of(error)}")
        return exits.FAILED
    if death is not None:
        lost.append(death)
        _print_death(death, errors)
    if lost:
        return exits.FAILED if lost[0].refused else exits.PROCESS_LOST
    console.print("the run has ended")
    return exits.OK


def _print_death(death: Death, errors: Console) -> None:
    errors.print(str(death))
    for line in death.tail:
        errors.print(f"  {line}")
