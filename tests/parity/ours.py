"""Runs the same cases in Zenvoy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

from tests.parity.cases import (
    BRAKING_MPS2,
    DURATION_S,
    FREE_MPS2,
    LENGTH_M,
    STEP_S,
    Case,
    Motion,
    wanted_mps,
)
from zenvoy.scenarios import Loaded, load
from zenvoy.studies.batches import run_batch

PLATOON: Final = Path(__file__).with_name("platoon.yaml")
_WANTED: Final = {"/fleet/truth": ["position", "speed"]}


def motion(case: Case) -> Motion:
    """Return the motion of a case."""
    loaded = _loaded(case)
    if case.manoeuvre == "sine":
        loaded = _oscillating(loaded)
    (run,) = run_batch([loaded], _WANTED)
    position = run.truth["position"]
    return Motion(position[:, :-1] - position[:, 1:] - LENGTH_M, run.truth["speed"])


def _loaded(case: Case) -> Loaded:
    gap_m = case.law.bumper_gap_m
    limit_mps2 = FREE_MPS2 if case.limited == "nothing" else BRAKING_MPS2
    settings = [
        f"duration_s={DURATION_S[case.manoeuvre]}",
        f"fleet.bumper_gap_m={gap_m!r}",
        f"control.desired_bumper_gap_m={gap_m!r}",
        f"vehicle.max_acceleration_mps2={limit_mps2}",
        f"vehicle.max_deceleration_mps2={limit_mps2}",
        *case.law.zenvoy,
    ]
    if case.manoeuvre == "braking":  # a gain so large that the leader brakes as hard as it can
        leader = {"gains.k_c": 1000, "vehicle.max_deceleration_mps2": BRAKING_MPS2}
        settings += [f"fleet.groups.0.{key}={value}" for key, value in leader.items()]
    return load(PLATOON, settings)


def _oscillating(loaded: Loaded) -> Loaded:
    """Return the scenario with a leader that gets a new desired speed in every step."""
    control = loaded.scenario.control
    (one,) = control.schedule
    schedule = tuple(
        one.model_copy(
            update={"at_s": round(step * STEP_S, 2), "desired_speed_mps": wanted_mps(step)}
        )
        for step in range(loaded.scenario.cycles)
    )
    scheduled = control.model_copy(update={"schedule": schedule})
    return replace(loaded, scenario=loaded.scenario.model_copy(update={"control": scheduled}))
