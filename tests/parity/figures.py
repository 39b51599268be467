"""Figures of both simulators, side by side."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from tests.parity import ours, sumo
from tests.parity.cases import (
    LAWS,
    THAT_COLLIDE,
    Case,
    Floats,
    Law,
    Limited,
    Manoeuvre,
    Motion,
    swing,
)
from tests.parity.tables import Compared

Figure = Callable[[Motion], Floats]


def swings_of_gaps(motion: Motion) -> Floats:
    """Return half the range of each gap within the window, m."""
    return swing(motion.gap)


def ratios_of_speeds(motion: Motion) -> Floats:
    """Return by how much the speed of each vehicle swings, relative to the vehicle ahead."""
    swings = swing(motion.speed)
    return swings[1:] / swings[:-1]


def smallest_gaps(motion: Motion) -> Floats:
    """Return the smallest gap of each vehicle, m."""
    gaps: Floats = motion.gap.min(axis=0)
    return gaps


def compared(figure: Figure, manoeuvre: Manoeuvre, limited: Limited = "nothing") -> list[Compared]:
    """Return a figure under each law."""
    theirs, own = _theirs(manoeuvre, limited), _own(manoeuvre, is_limited=limited != "nothing")
    return [Compared(law, figure(motion), figure(own[law])) for law, motion in theirs.items()]


@cache
def _theirs(manoeuvre: Manoeuvre, limited: Limited) -> dict[str, Motion]:
    """Run every law in SUMO."""
    laws = _laws(manoeuvre)
    return _by_name(laws, sumo.motions(laws, manoeuvre, limited))


@cache
def _own(manoeuvre: Manoeuvre, *, is_limited: bool) -> dict[str, Motion]:
    """Run every law in Zenvoy."""
    laws = _laws(manoeuvre)
    limited: Limited = "commands" if is_limited else "nothing"
    return _by_name(laws, [ours.motion(Case(law, manoeuvre, limited)) for law in laws])


def _laws(manoeuvre: Manoeuvre) -> list[Law]:
    return [law for law in LAWS if manoeuvre == "sine" or law not in THAT_COLLIDE]


def _by_name(laws: list[Law], motions: list[Motion]) -> dict[str, Motion]:
    return {law.name: motion for law, motion in zip(laws, motions, strict=True)}
