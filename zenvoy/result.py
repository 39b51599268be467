"""A run, read from its log."""

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
    """A run, read from its log.

    `truth`, `radar`, `estimate`, `command` and `clock` map names of columns to arrays with a row
    per cycle and a column per vehicle; column v - 1 is vehicle v. `frames` has a row per frame and
    receiver, and is read from the log on first use. `units` has the unit of every column, `time_s`
    the time of each row of `truth`, `events` the events of the run, and `notes` anything wrong with
    the log. `fingerprint` is equal for equal scenario and seed, whatever the engine.
    """

    @property
    def log(self) -> Path:
        """The log of the run, an MCAP file."""
        return super().log

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The summary that `zenvoy run` writes to summary.json; the keys name the units."""
        try:
            return summary_of(self)
        except analysis.LogError as error:
            raise errors.LogError(str(error)) from error


def load(log: str | PathLike[str]) -> Run:
    """Return the run that is logged in an MCAP file, up to the first cut or gap if there is one.

    The log is checked on the way; `notes` of the run lists the checks that fail. Raises LogError.
    """
    try:
        run = analysis.load(Path(fspath(log)))
    except analysis.LogError as error:
        raise errors.LogError(str(error)) from error
    return Run(**{field.name: getattr(run, field.name) for field in fields(run)})
