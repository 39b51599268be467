"""The numbers of a law that a fit may choose, with their ranges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple

from pydantic.fields import FieldInfo

from zenvoy.laws import Law, Observation, Output, Relative, Setpoint
from zenvoy.laws.parameters import model_of, parameters_of
from zenvoy.scenarios.convoys.cutting import LENGTH_M
from zenvoy.scenarios.convoys.errors import ConvoyError
from zenvoy.scenarios.errors import Problem
from zenvoy.studies.convoys.following import called
from zenvoy.values.wording import listed, shown

# Ranges of what the scenario sets for a law: gains, and the gap from front to front.
_SETPOINT: Final = {
    "k_d": (0.005, 2.0),
    "k_v": (0.0, 5.0),
    "k_c": (0.0, 1.0),
    "desired_gap_m": (LENGTH_M + 0.5, LENGTH_M + 100.0),
}
_FIELDS: Final = {"k_d": "k_d", "k_v": "k_v", "k_c": "k_c", "desired_gap_m": "p_des"}
_FACTOR: Final = 10.0  # without other limits a parameter is within 1/10 and 10 times its default
_WIDE: Final = 1e6  # a higher upper limit does not bound sensible values


@dataclass(frozen=True, slots=True, kw_only=True)
class Free:
    """A number that a fit chooses in [low, high], beginning at start.

    of: whether it is a parameter of the law, or a value that the scenario sets for all laws.
    """

    name: str
    low: float
    high: float
    start: float
    of: Literal["law", "scenario"] = "law"


class Values(NamedTuple):
    """Parameters of a law's own type, and its setpoint."""

    parameters: Any
    setpoint: Setpoint


def free_in(law: Law, setpoint: Setpoint, bounds: Mapping[str, tuple[float, float]]) -> list[Free]:
    """Return the numbers of a law that can be fitted; `bounds` replace their ranges.

    They are the parameters that are real numbers, within the limits of their annotations and
    within ten times their defaults, and of the gains and the desired gap those that the law uses.
    Raises ConvoyError if there are none, or if a bound is not for one of them.
    """
    model = model_of(law.parameters)
    found = [
        one
        for name, info in model.model_fields.items()
        if info.annotation is float and (one := _parameter(name, info)) is not None
    ]
    found += [
        Free(name=name, low=low, high=high, start=getattr(setpoint, _FIELDS[name]), of="scenario")
        for name, (low, high) in _SETPOINT.items()
        if _is_used(law, setpoint, _FIELDS[name])
    ]
    if not found:
        text = f"{law.name} has no number that could be fitted: no parameter with a default or "
        raise ConvoyError([Problem(key="--law", text=f"{text}with limits, and it uses no gains")])
    unknown = [name for name in bounds if name not in [one.name for one in found]]
    if unknown:
        names = listed([one.name for one in found])
        text = f"{shown(unknown[0])} is not a number of {law.name}; allowed: one of {names}"
        raise ConvoyError([Problem(key="--bound", text=text)])
    return [_bounded(one, bounds.get(one.name)) for one in found]


def values_at(law: Law, setpoint: Setpoint, free: list[Free], at: Mapping[str, float]) -> Values:
    """Return parameters and setpoint with these numbers; raises ValueError if the law refuses."""
    given = {one.name: at[one.name] for one in free if one.of == "law"}
    of_scenario = {_FIELDS[one.name]: at[one.name] for one in free if one.of == "scenario"}
    return Values(parameters_of(law.parameters, given), setpoint._replace(**of_scenario))


def _bounded(one: Free, given: tuple[float, float] | None) -> Free:
    low, high = (one.low, one.high) if given is None else given
    start = min(max(one.start, low + 0.01 * (high - low)), high - 0.01 * (high - low))
    return Free(name=one.name, low=low, high=high, start=start, of=one.of)


def _parameter(name: str, info: FieldInfo) -> Free | None:
    """Return a parameter with its range; None if neither limits nor a default give one."""
    limits: dict[str, float] = {}
    for constraint in info.metadata:
        for kind in ("ge", "gt", "le", "lt"):
            if (limit := getattr(constraint, kind, None)) is not None:
                limits[kind[0]] = float(limit)
    low, high = limits.get("g"), limits.get("l")
    default = info.default if isinstance(info.default, float | int) else None
    if high is None or high > _WIDE:
        if not default:
            return None
        ends = sorted((default / _FACTOR, default * _FACTOR))
        low = ends[0] if low is None else max(low, ends[0])
        high = ends[1]
    elif low is None:
        return None
    return Free(name=name, low=low, high=high, start=0.5 * (low + high) if default is None
                else float(default))  # fmt: skip


def _is_used(law: Law, setpoint: Setpoint, field: str) -> bool:
    """Return whether the law's acceleration depends on a field of its setpoint."""
    others = setpoint._replace(**{field: getattr(setpoint, field) * 1.25 + 0.125})
    parameters = parameters_of(law.parameters, {})
    return any(
        _at(law, parameters, one, *seen) != _at(law, parameters, other, *seen)
        for one, other in ((setpoint, others),)
        for seen in ((10.0, 30.0, 0.5), (25.0, 12.0, -1.0), (5.0, 60.0, 2.0))
    )


def _at(
    law: Law, parameters: Any, setpoint: Setpoint, v: float, gap: float, relative: float
) -> float:
    """Return the acceleration of a law at a speed, a gap and a relative speed."""
    seen = Observation(
        v,
        setpoint,
        Relative(gap, relative),
        state=law.state,
        period_s=0.1,
        uniform=lambda _: 0.5,
        acceleration=0.0,
        length_m=LENGTH_M,
    )
    returned = called(law, seen, parameters)
    return float(returned.acceleration if isinstance(returned, Output) else returned)
