"""Tests whether a law takes arrays, with some vehicles one by one and all at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from zenvoy.laws import Law, Motion, Observation, Output, Relative, Setpoint, where
from zenvoy.laws.errors import described, errors_of_the_code, shortened
from zenvoy.laws.relative import NAN, Number
from zenvoy.vehicles.arrays.exact import InexactError, exact
from zenvoy.vehicles.arrays.strict import strict_arithmetic
from zenvoy.vehicles.time_limit import time_limit

_SITUATIONS = np.array(
    [  # k_d, k_v, k_c, p_des, v_des; own speed; link ahead, behind; predecessor, leader
        (0.1, 0.5, 0.05, 37.5, 30.0, 30.0, 37.5, 0.0, 37.5, 0.0, 30.0, 0.0, 30.0, 0.0),
        (0.1, 0.5, 0.05, 37.5, 30.0, 0.0, 5.5, -0.5, 80.0, 3.0, 0.0, -3.0, 28.0, 1.0),
        (0.2, 0.1, -0.05, 20.0, 25.0, 12.5, 90.0, 8.0, 6.0, -7.0, 20.5, 2.0, 19.0, -1.0),
        (1.0, 0.0, 0.0, 50.0, 35.0, 34.9, 49.0, -12.0, 51.0, 12.0, 22.9, -2.5, 35.0, 0.5),
    ]
)
_NEARBY = 16  # points of each situation: in a transcendental function few values differ
_POINTS = np.concatenate(
    [
        _SITUATIONS * (1.0 + step * np.arange(1, _SITUATIONS.shape[1] + 1) / 4096.0)
        for step in range(_NEARBY)
    ]
)
"""Each column is scaled by its own factor. Signs and zeros stay."""


class _FaultError(Exception):
    """A law has raised an exception; the text is a line about it."""


def _of(error: BaseException) -> _FaultError:
    if isinstance(error, InexactError):
        return _FaultError(str(error))
    return _FaultError(f"it raises {described(error)}")


def fault_on_arrays(law: Law, parameters: Any, limit_s: float) -> str | None:
    """Return why a law does not take arrays, in a few words; None if it does.

    The law must return the same bits for several vehicles at once as for each of them. The trial
    may take limit_s of wall time. A law that makes plain arrays of its arguments, as numpy.asarray
    does, hides its operations: then only the values are compared.
    """
    try:
        with errors_of_the_code(_of), time_limit(limit_s), strict_arithmetic():
            alone = [_flat(law, parameters, tuple(point)) for point in _POINTS.tolist()]
            together = _flat(law, parameters, tuple(map(exact, _POINTS.T)))
    except _FaultError as error:
        return str(error)
    strange = [one for values in alone for one in values if not _is_number(one)]
    if strange:
        return f"it returns {shortened(strange[0])}, which is no number"
    if not all(_is_number(one) or _has_shape(one) for one in together):
        return "it returns arrays of another shape than it is given"
    if len({len(values) for values in (*alone, together)}) > 1:
        return "it does not always return as many values"
    for at, values in enumerate(alone):
        for one, both in zip(values, together, strict=True):
            there = np.broadcast_to(np.asarray(both), len(_POINTS))[at]
            if not np.array_equal(one, there, equal_nan=True):
                return "it gives other values on arrays than on floats"
    return None


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int | np.number | np.bool_)


def _has_shape(value: Any) -> bool:
    """Return whether a value has a number for each vehicle."""
    return isinstance(value, np.ndarray) and value.shape == _POINTS.shape[:1]


def _flat(law: Law, parameters: Any, point: tuple[Any, ...]) -> tuple[Any, ...]:
    k_d, k_v, k_c, p_des, v_des, speed, *rest = point
    ahead, behind = Relative(rest[0], rest[1]), Relative(rest[2], rest[3])
    shape = np.shape(speed)
    heard = where(speed > 20.0, 1.0, NAN) if law.needs.tolerates_silence else 1.0
    predecessor = _motion(heard, rest[4], rest[5], ahead.p, 1.0)
    leader = _motion(heard, rest[6], rest[7], 3.0 * ahead.p, 3.0)
    observation = Observation(
        speed,
        Setpoint(k_d, k_v, k_c, p_des, v_des),
        ahead,
        behind,
        tuple((ahead, behind) for _ in range(law.sides(parameters))),
        predecessor,
        leader,
        tuple(exact(np.full(shape, value)[()]) for value in law.state),
        0.1,
        lambda number: exact(np.full(shape, 1.0 / (2 + number))[()]),
        acceleration=0.5 * ahead.v,
        length_m=4.5,
    )
    returned = law.acceleration(observation, parameters)
    output = returned if isinstance(returned, Output) else Output(returned)
    return (output.acceleration, *output.logged, *output.state)


def _motion(heard: Number, v: Number, a: Number, distance: Number, steps: float) -> Motion:
    """Return a report; NaN where `heard` is NaN instead of 1."""
    return Motion(*(heard * one for one in (v, a, distance, 0.05 * a * a, a + 0.1, steps)))
