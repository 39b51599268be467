"""`zenvoy view`: a page in the browser that shows a run.

The command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

from typing import Annotated

import typer

from zenvoy.cli.log_commands import LogArgument
from zenvoy.cli.terminal import refuse, say


def view(
    log: LogArgument,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65_535, help="Port of the page [default: 8600, or a free one]."),
    ] = None,
) -> None:
    """Show a run in the browser, also one that goes on.

    Serves a page to this machine only, until Ctrl-C.
    """
    from zenvoy.analysis.log.records import LogError
    from zenvoy.analysis.view.server import PortError, address_of, listener
    from zenvoy.analysis.view.watched import WatchedRun
    from zenvoy.cli.viewing import show

    try:
        WatchedRun(log).extend()  # so that a file which is no log is refused at once
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
