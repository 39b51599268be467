"""`zenvoy view`: a page in the browser that shows a run.

The command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli.log_commands import LogArgument
from zenvoy.cli.terminal import refuse, say


def view(
    log: LogArgument,
    port: Annotated[
        int | None,
        typer.Option(
            min=0, max=65_535, help="Port [default: 8600, for Foxglove 8765, or a free one]."
        ),
    ] = None,
    foxglove: Annotated[
        bool, typer.Option("--foxglove", help="Serve it to Foxglove and Lichtblick instead.")
    ] = False,
) -> None:
    """Show a run in the browser, also one that goes on.

    Serves a page to this machine only, until Ctrl-C.
    """
    if foxglove:
        _to_foxglove(log, port)
        return
    from zenvoy.analysis.log.records import LogError
    from zenvoy.analysis.view.listening import PortError, address_of, listener
    from zenvoy.analysis.view.watched import WatchedRun
    from zenvoy.cli.viewing import show

    try:
        WatchedRun(log).first_look()  # so that a file which is no log is refused at once
        made = listener(port)
    except LogError as error:
        refuse(str(error))
    except PortError as error:
        refuse(f"--{error}")
    say(f"{log} is shown at {address_of(made)}  (Ctrl-C ends it)")
    try:
        show(log, made)
    except LogError as error:
        refuse(str(error))


def _to_foxglove(log: Path, port: int | None) -> None:
    from zenvoy.cli.foxglove_viewing import address_at, refuse_without_foxglove, serve_log

    refuse_without_foxglove()
    from zenvoy.analysis.log.records import LogError
    from zenvoy.analysis.view.growing_log import GrowingLog
    from zenvoy.analysis.view.listening import PortError

    def ready(port: int) -> None:
        say(f"{log} is served to Foxglove at {address_at(port)}  (Ctrl-C ends it)")

    begun = GrowingLog(log)
    try:
        begun.first_look()  # so that a file which is no log is refused at once
        serve_log(log, port, begun.vehicles, ready)
    except LogError as error:
        refuse(str(error))
    except PortError as error:
        refuse(f"--{error}")
