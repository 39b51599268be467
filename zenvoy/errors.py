"""What `zenvoy.run`, `zenvoy.load` and `zenvoy.scenario` raise, in one tree.

Each text is the line, or the lines, that the `zenvoy` command prints.
"""

from __future__ import annotations

from pathlib import Path


class ZenvoyError(Exception):
    """Base of all errors below."""


class InputError(ZenvoyError, ValueError):
    """What is asked for cannot be; nothing was run."""


class ScenarioError(InputError):
    """There is no such scenario, or it is not valid: a line for each problem, with its place."""


class FolderError(InputError):
    """The folder for a run cannot be made, or is not empty."""


class LogError(InputError):
    """The file is no log of a run, or cannot be read."""


class RunError(ZenvoyError):
    """A run could not begin, or could not go on: no room on the disk, too few processes, …"""

    def __init__(self, text: str, log: Path | None = None) -> None:
        super().__init__(text)
        self.log = log
        """The log up to here, for `zenvoy.load`; None where there is none."""


class ProcessLostError(RunError):
    """A process of the run died or stalled; the text says which one, and what became of it."""

    def __init__(self, text: str, log: Path | None, process: str, output: tuple[str, ...]) -> None:
        super().__init__(text, log)
        self.process = process
        """Its name, such as `vehicle-07`."""
        self.output = output
        """The last lines that it has printed."""
