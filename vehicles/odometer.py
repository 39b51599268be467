"""Odometers by dead reckoning, and the states of links that follow from them: floats or arrays.

An odometer integrates a vehicle's readings of its own acceleration from its first cycle on. The gap
of a link is an offset plus the difference of the odometers at its ends: g = c + p_front - p_rear.
Nothing but the offset is unknown, and it only drifts, whatever the vehicles do.
"""

from __future__ import annotations

from typing import NamedTuple

from zenvoy.laws import Relative
from zenvoy.vehicles.steps import Number


class Odometer(NamedTuple):
    """Distance p beyond uniform motion (m) and speed v (m/s) gained since the odometer began."""

    p: Number
    v: Number


def moved(at: Odometer, dt_s: Number, by: tuple[Number, Number]) -> Odometer:
    """Return an odometer dt_s later.

    by: displacement beyond uniform motion (m) and change of speed (m/s) in that time.
    """
    dp, dv = by
    return Odometer(at.p + at.v * dt_s + dp, at.v + dv)


def coasted(at: Odometer, dt_s: Number) -> Odometer:
    """Return an odometer dt_s later, without any acceleration."""
    return Odometer(at.p + at.v * dt_s, at.v)


def offset_of(state: Relative, front: Odometer, rear: Odometer) -> Relative:
    """Return the offset of a link with this state, at the time of both odometers."""
    return Relative(state.p - (front.p - rear.p), state.v - (front.v - rear.v))


def state_of(offset: Relative, dt_s: Number, front: Odometer, rear: Odometer) -> Relative:
    """Return the state of a link dt_s after the time of its offset, by the odometers then."""
    drifted = offset.p + offset.v * dt_s
    return Relative(drifted + (front.p - rear.p), offset.v + (front.v - rear.v))
