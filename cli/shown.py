"""Runs a scenario while servers beside the run show it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

from zenvoy.cli.foxglove_viewing import FoxgloveServer
from zenvoy.cli.viewing import Viewer
from zenvoy.fleet.requests import interruptible
from zenvoy.scenarios import Scenario


def run_shown(
    run_it: Callable[..., int], scenario: Scenario, *, page: bool, foxglove: bool, kills: bool
) -> int:
    """Run a scenario, shown on a page, to Foxglove or both; stay afterwards, and return the code.

    `run_it` is `zenvoy.cli.execute.execute` without what the servers need of it. `kills`: each
    vehicle has a process of its own on this machine, which the page may kill.
    """
    with interruptible(), ExitStack() as servers:
        viewer = servers.enter_context(closing(Viewer(scenario, kills=kills))) if page else None
        served = servers.enter_context(closing(FoxgloveServer(scenario))) if foxglove else None
        shown = [server for server in (viewer, served) if server is not None]

        def begin(folder: Path) -> None:
            for server in shown:
                server.begin(folder)

        code = run_it(on_folder=begin, by_hand=None if viewer is None else viewer.by_hand)
        shown[0].stay(code)
        return code
