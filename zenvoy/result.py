"""A run, read from its log."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from zenvoy import analysis, errors
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.measures.summary import summary_of


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Run(analysis.Run):
    """A run that has a log, as `zenvoy.run` and `zenvoy.load` return it.

    It has all attributes of `zenvoy.analysis.Run`, a summary, and the errors of `zenvoy`. `truth`,
    `radar`, `estimate` and `command` map names of columns to arrays with a row per cycle and a
    column per vehicle; column v - 1 is vehicle v. `fingerprint` is equal for equal scenario and
    seed, whatever the engine.
    """

    @property
    def log(self) -> Path:
        """The path of the log, an MCAP file."""
        return super().log

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The summary that `zenvoy run` writes to summary.json; the keys name the units.

        Raises LogError.
        """
        with _errors_of_logs():
            return summary_of(self)

    @cached_property
    def frames(self) -> Table:
        """The table of frames, a row per frame and receiver, read from the log on first use.

        Raises LogError.
        """
        with _errors_of_logs():
            return super().frames

    @cached_property
    def busy_ratio(self) -> NDArray[np.float64]:
        """The share of each cycle in which each vehicle sensed the medium busy, (cycles, vehicles).

        It is (0, vehicles) where frames do not contend for the medium. Raises LogError.
        """
        with _errors_of_logs():
            return super().busy_ratio


def load(log: str | PathLike[str]) -> Run:
    """Return the run that is logged in an MCAP file, up to the first cut or gap if there is one.

    The log is checked on the way; `notes` of the run lists the checks that fail. Raises LogError.
    """
    with _errors_of_logs():
        run = analysis.load(Path(fspath(log)))
    return Run(**{field.name: getattr(run, field.name) for field in fields(run)})


@contextmanager
def _errors_of_logs() -> Iterator[None]:
    """Raise the LogError of this package in place of that of the analysis."""
    try:
        yield
    except analysis.LogError as error:
        raise errors.LogError(str(error)) from error
