"""What there is to decide on, of every vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

from zenvoy.laws import Motion, Relative
from zenvoy.laws.law import SILENT
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints


class Known(NamedTuple):
    """A state that is not known of everyone; there: of whom it is, None: of all."""

    state: Relative
    there: Bools | None = None


class Reported(NamedTuple):
    """What others report of their motion; there: whose report is fresh, None: everyone's."""

    motion: Motion
    there: Bools | None = None


NOTHING: Final = Reported(SILENT)


class Seen(NamedTuple):
    """What a law decides on: states of both links, and own speed (m/s)."""

    ahead: Known
    behind: Known
    speed: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What there is to decide on, of every vehicle.

    radar: the own one's reading. read: the newest readings. predicted: the estimates at the effect
    of the command, where somebody asks for them. sides: states to the j-th vehicle ahead and
    behind; known_sides: how many of these are known, on both sides. first, last: who stands at the
    ends of an open road.
    """

    radar: Relative
    read: Seen
    predicted: Seen | None = None
    sides: tuple[tuple[Relative, Relative], ...] = ()
    known_sides: Ints | None = None
    predecessor: Reported = NOTHING
    leader: Reported = NOTHING
    first: Bools | None = None
    last: Bools | None = None
