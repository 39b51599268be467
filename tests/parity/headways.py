"""The smallest headways with which Ploeg's loop is string stable, by runs of its vehicles.

Within a run each vehicle may have its own headway and delay: with equal actuators, the gain from
the speed of the vehicle ahead to the own one does not depend on how that vehicle is controlled.

A command is in the beacon of the cycle after its decision, and a step of Euler's filter is that
much ahead of the exact one. So the delay of the loop is the latency of the channel.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from tests.parity.cases import Floats
from tests.parity.loops import K_D, K_P, LOOPS, Loop, Motion
from zenvoy.scenarios import Loaded, load
from zenvoy.studies.batches import run_batch

Vehicle = tuple[Loop, float]
"""A loop, and a headway in s."""

TOLERANCE: Final = 0.005
_FIRST: Final = 3  # vehicle 2 is there because the leader does not report what it commands
_SPEED_MPS: Final = 25.0
_AMPLITUDE_MPS: Final = 0.2
_AIM_EVERY_S: Final = 0.1  # a new desired speed of the leader
_LOOPS: Final = Path(__file__).with_name("loops.yaml")


def limits_in_runs() -> list[float]:
    """Return the smallest headway of each loop (s) in runs, by bisection to TOLERANCE."""
    low = {loop: 0.5 * loop.published_s for loop in LOOPS}
    high = {loop: 2.0 * loop.published_s for loop in LOOPS}
    while any(high[loop] - low[loop] > TOLERANCE * low[loop] for loop in LOOPS):
        middle = [(loop, 0.5 * (low[loop] + high[loop])) for loop in LOOPS]
        for (loop, headway_s), amplified in zip(middle, amplify(middle), strict=True):
            (low if amplified else high)[loop] = headway_s
    return [0.5 * (low[loop] + high[loop]) for loop in LOOPS]


def amplify(vehicles: Sequence[Vehicle]) -> list[bool]:
    """Return whether a vehicle with this loop and headway amplifies any frequency in a run."""
    gains = gains_in_runs(vehicles)
    return [bool((gains[vehicle] > 1.0).any()) for vehicle in vehicles]


def gains_in_runs(vehicles: Sequence[Vehicle]) -> dict[Vehicle, Floats]:
    """Return the gain of each vehicle at the frequencies of its leader's motion.

    Vehicles whose leaders move equally share a run.
    """
    found: dict[Vehicle, Floats] = {}
    for motion in dict.fromkeys(loop.motion for loop, _ in vehicles):
        some = [vehicle for vehicle in vehicles if vehicle[0].motion == motion]
        (run,) = run_batch([_scenario(some, motion)], {"/fleet/truth": ["speed"]})
        gains = _gains(run.truth["speed"], motion)[:, _FIRST - 2 :]
        found |= dict(zip(some, gains.T, strict=True))
    return found


def _gains(speed: Floats, motion: Motion) -> Floats:
    """Return the gains of vehicles 2, 3, … (columns) over the last period of the leader."""
    samples = round(1e3 * motion.period_s / motion.step_ms)
    turns = np.arange(samples) / samples
    waves = np.exp(-2j * math.pi * np.outer(motion.harmonics, turns))
    parts = np.abs(waves @ (speed[-samples:] - _SPEED_MPS))
    gains: Floats = parts[:, 1:] / parts[:, :-1]
    return gains


def _scenario(vehicles: Sequence[Vehicle], motion: Motion) -> Loaded:
    numbered = list(enumerate(vehicles, start=_FIRST))
    leader: dict[str, Any] = {"name": "leader", "vehicles": 1, "gains": {"k_c": 1}}
    settings = {
        "duration_s": motion.settles_s + motion.period_s,
        "period_ms": motion.step_ms,
        "fleet.size": len(vehicles) + _FIRST - 1,
        "fleet.groups": [leader, *(_group(number, *one) for number, one in numbered)],
        "fleet.initial_gaps_m": [6.0 + h * _SPEED_MPS for h in (0.5, *(h for _, h in vehicles))],
        "channel.rules": [
            _rule(number, loop.delay_s) for number, (loop, _) in numbered if loop.delay_s
        ],
    }
    loaded = load(_LOOPS, [f"{key}={json.dumps(value)}" for key, value in settings.items()])
    return _oscillating(loaded, motion)


def _group(number: int, loop: Loop, headway_s: float) -> dict[str, Any]:
    return {
        "name": f"vehicle_{number}",
        "vehicles": number,
        "model": "./ploeg_alone.py:LAW" if loop.delay_s is None else "Ploeg",
        "parameters": {"k_p": K_P, "k_d": K_D, "headway_s": headway_s},
    }


def _rule(number: int, delay_s: float) -> dict[str, Any]:
    latency = {"distribution": "fixed", "mean_ms": 1e3 * delay_s}
    return {"destination": number, "latency": latency}


def _oscillating(loaded: Loaded, motion: Motion) -> Loaded:
    """Return the scenario with a leader that moves with all frequencies at once."""
    control = loaded.scenario.control
    (one,) = control.schedule
    times_s = np.arange(0.0, loaded.scenario.duration_s, _AIM_EVERY_S).tolist()
    schedule = tuple(
        one.model_copy(update={"at_s": round(at, 2), "desired_speed_mps": _aim_mps(at, motion)})
        for at in times_s
    )
    scheduled = control.model_copy(update={"schedule": schedule})
    return replace(loaded, scenario=loaded.scenario.model_copy(update={"control": scheduled}))


def _aim_mps(at_s: float, motion: Motion) -> float:
    """Return the desired speed of the leader; the phases keep its peaks low (Schroeder, 1970)."""
    count = len(motion.harmonics)
    waves = (
        math.sin(math.tau * harmonic * at_s / motion.period_s - math.pi * rank * rank / count)
        for rank, harmonic in enumerate(motion.harmonics)
    )
    return _SPEED_MPS + _AMPLITUDE_MPS * sum(waves)
