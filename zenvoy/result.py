"""A run as its log has it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from zenvoy import analysis, errors
from zenvoy.analysis.measures.summary import summary_of


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Run(analysis.Run):
    """A run, as its log tells it.

    `truth`, `radar`, `estimate`, `command` and `clock` map names of columns to arrays of a row per
    cycle and a column per vehicle; column v - 1 is vehicle v. `frames` has a row per frame and
    receiver, and is read from the log on first use. `units` has the unit of every column, `time_s`
    the time of each row of truth, `events` what happened, `notes` what is not as it should be, and
    `fingerprint` is equal for equal scenario and seed, whatever the engine.
    """

    @property
    def log(self) -> Path:
        """The log of the run, an MCAP file."""
        return self.path

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What the command `zenvoy run` prints and leaves in summary.json; units in the names."""
        try:
            return summary_of(self)
        except analysis.LogError as error:
            raise errors.LogError(str(error)) from error


def load(log: str | PathLike[str]) -> Run:
    """Return the run that is logged in an MCAP file, up to a cut or a gap where there is one.

    What the log says of itself is checked on the way; what does not hold is in `notes`. Raises
    LogError.
    """
    try:
        run = analysis.load(Path(fspath(log)))
    except analysis.LogError as error:
        raise errors.LogError(str(error)) from error
    return Run(**{field.name: getattr(run, field.name) for field in fields(run)})
