"""The frames that the chapter on V2V shows: logged by a run, or drawn from a channel alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.columns import Table
from zenvoy.scenarios import Scenario

Floats = NDArray[np.float64]


class Traffic(Protocol):
    """A scenario and the frames of its fleet; a `Run` is one."""

    @property
    def scenario(self) -> Scenario:
        """The scenario with all its defaults."""

    @property
    def vehicles(self) -> int:
        """The number of vehicles; they are numbered from 1."""

    @property
    def frame_rows(self) -> int:
        """The number of rows of `frames`."""

    @property
    def frames(self) -> Table:
        """Columns of /v2v/frames, a row per frame and receiver, in order of time."""

    @property
    def busy_ratio(self) -> Floats:
        """The share of each cycle in which each vehicle sensed the medium busy, (cycles, vehicles).

        It is (0, vehicles) if frames do not contend for the medium.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class DrawnTraffic:
    """Frames that were drawn from a channel without a run."""

    scenario: Scenario
    frames: Table
    busy_ratio: Floats

    @property
    def vehicles(self) -> int:
        """The number of vehicles; they are numbered from 1."""
        return self.scenario.fleet.size

    @property
    def frame_rows(self) -> int:
        """The number of rows of `frames`."""
        return len(self.frames["source"])
