"""The data on which the vehicles decide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

from zenvoy.laws import Motion, Relative
from zenvoy.laws.law import SILENT
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints


class Known(NamedTuple):
    """The relative states of a link.

    there is a mask of the vehicles for which the state is known; None means all of them.
    """

    state: Relative
    there: Bools | None = None


class Reported(NamedTuple):
    """The motions that senders report.

    there is a mask of the vehicles whose report is fresh; None means all of them.
    """

    motion: Motion
    there: Bools | None = None


NOTHING: Final = Reported(SILENT)


class Seen(NamedTuple):
    """The data of a law: the states of both links, and the own speed (m/s)."""

    ahead: Known
    behind: Known
    speed: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """The data on which the vehicles decide in a cycle.

    radar is the reading of the own radar, and read has the newest readings of all sources.
    predicted has the estimates at the effect of the commands, if any law needs them. sides has
    the states to the j-th vehicle ahead and behind, and known_sides is the number of vehicles
    that are known on both sides. acceleration has the own readings, m/s². behind_age_s has the
    ages of what is known of shared links behind, s; NaN where nothing is known. first and last
    are masks of the vehicles at the ends of an open road.
    """

    radar: Relative
    read: Seen
    predicted: Seen | None = None
    sides: tuple[tuple[Relative, Relative], ...] = ()
    known_sides: Ints | None = None
    predecessor: Reported = NOTHING
    leader: Reported = NOTHING
    acceleration: Floats
    behind_age_s: Floats | None = None
    first: Bools | None = None
    last: Bools | None = None
