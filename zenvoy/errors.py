"""The errors of `zenvoy.run`, `zenvoy.load` and `zenvoy.scenario`, in one tree.

The text of each error is what the `zenvoy` command prints, with arguments in place of its options.
"""

from __future__ import annotations

from pathlib import Path


class ZenvoyError(Exception):
    """Base class of all errors of Zenvoy."""


class InputError(ZenvoyError, ValueError):
    """The input is not valid; nothing was run."""


class ScenarioError(InputError):
    """The scenario does not exist or is not valid; the text has a line per problem."""


class FolderError(InputError):
    """The folder for a run cannot be made, or is not empty."""


class LogError(InputError):
    """The file cannot be read, or is not the log of a run."""


class RunError(ZenvoyError):
    """A run could not begin or go on, for example because the disk is full."""

    log: Path | None
    """The log of the run so far, for `zenvoy.load`; None if there is none."""

    def __init__(self, text: str, log: Path | None = None) -> None:
        super().__init__(text)
        self.log = log


class ProcessLostError(RunError):
    """A process of the run died or stalled; the text says which one, and how."""

    process: str
    """The name of the process, such as `vehicle-07`."""
    output: tuple[str, ...]
    """The last lines that the process printed."""

    def __init__(
        self, text: str, log: Path | None = None, process: str = "", output: tuple[str, ...] = ()
    ) -> None:
        super().__init__(text, log)  # the text alone makes an error again when it is unpickled
        self.process = process
        self.output = output
