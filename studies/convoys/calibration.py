"""Fits a law to every car of a recorded convoy, and tests the fits on other recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

from zenvoy.laws import Law, builtin, law_of
from zenvoy.laws.by_name import resolve
from zenvoy.laws.code import CodeElsewhereError
from zenvoy.laws.errors import UnknownLawError
from zenvoy.scenarios import Problem, Scenario, roster, setpoint_at
from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.scenarios.convoys.errors import ConvoyError
from zenvoy.scenarios.convoys.scenario_of import values_of
from zenvoy.studies.convoys.fitting import Fit, Task, errors, fitted
from zenvoy.studies.convoys.following import Pair, Timing, pairs_of
from zenvoy.studies.convoys.free import free_in
from zenvoy.studies.convoys.parallel import mapped
from zenvoy.values.wording import shown

Bounds = Mapping[str, tuple[float, float]]

_AHEAD_ONLY: Final = "allowed: a law that looks ahead by its own radar only"


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """The errors of a fit on another recording of the same car: gap (m) and speed (m/s), RMS."""

    recording: str
    rms_gap_m: float
    rms_speed_mps: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """A law fitted to the followers of a convoy, in their order.

    held has the errors of each fit on the other recordings that have such a car.
    """

    convoy: Convoy
    task: Task
    pairs: Sequence[Pair]
    fits: Sequence[Fit]
    held: Sequence[Sequence[Held]]

    @property
    def law(self) -> Law:
        """The law that was fitted."""
        return law_of(self.task.model)


def law_named(name: str, *, allow_code: bool = False) -> str:
    """Return the reference of a law, in small letters or not; raises ConvoyError."""
    known = {law.lower(): law for law in builtin()}
    try:
        return known.get(name.lower()) or resolve(name, Path(), allow_code=allow_code)
    except UnknownLawError as error:
        hint = "; --allow-code runs it" if isinstance(error, CodeElsewhereError) else ""
        raise _refused(f"{shown(name)}: {error}{hint}") from None


def model_named(name: str, *, allow_code: bool = False) -> str:
    """Return the reference of a law that may be fitted; raises ConvoyError."""
    model = law_named(name, allow_code=allow_code)
    needs = law_of(model).needs
    others = needs.behind or needs.sides or needs.predecessor or needs.leader or needs.prediction
    if others or law_of(model).section is not None:
        raise _refused(f"{law_of(model).name} uses what others report; {_AHEAD_ONLY}")
    return model


def task_for(convoy: Convoy, model: str, bounds: Bounds) -> Task:
    """Return the task of fitting a law to a convoy; raises ConvoyError."""
    scenario = Scenario.model_validate(values_of(convoy, points=True))
    setpoint = setpoint_at(roster(scenario)[1].targets, 0)
    return Task(
        model=model,
        free=tuple(free_in(law_of(model), setpoint, bounds)),
        setpoint=setpoint,
        timing=Timing.of(scenario),
    )


def calibrate(
    convoy: Convoy,
    model: str,
    *,
    bounds: Bounds,
    hold_out: Sequence[Convoy] = (),
    jobs: int = 1,
    on_fit: Callable[[Fit], None] = lambda _: None,
) -> Calibration:
    """Return a law fitted to each follower of a convoy, with its errors on other recordings.

    Raises ConvoyError.
    """
    task = task_for(convoy, model, bounds)
    pairs = pairs_of(convoy, task.timing.period_s)
    fits = mapped(partial(fitted, task), pairs, jobs, lambda _, fit: on_fit(fit))
    return Calibration(
        convoy=convoy,
        task=task,
        pairs=pairs,
        fits=fits,
        held=[_held(task, fit, hold_out) for fit in fits],
    )


def _held(task: Task, fit: Fit, hold_out: Sequence[Convoy]) -> list[Held]:
    """Return the errors of a fit wherever the same car follows another."""
    found = []
    for other in hold_out:
        for pair in pairs_of(other, task.timing.period_s):
            if pair.car == fit.car:
                gap, speed = errors(task, fit.values, pair)
                found.append(Held(recording=other.name, rms_gap_m=gap, rms_speed_mps=speed))
    return found


def _refused(text: str) -> ConvoyError:
    return ConvoyError([Problem(key="--law", text=text)])
