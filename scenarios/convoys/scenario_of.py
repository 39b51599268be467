"""Makes a scenario from a convoy: its leader drives as recorded, and a law drives the others."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from zenvoy.scenarios.convoys.convoy import Convoy
from zenvoy.scenarios.convoys.cutting import LENGTH_M
from zenvoy.scenarios.convoys.kept import LEADER

_LEAST_GAP_M: Final = 0.01  # a smaller gap at the start would be a collision


def values_of(convoy: Convoy, *, points: bool = False) -> dict[str, Any]:
    """Return the values by which the scenario of a convoy differs from the defaults.

    The leader follows the trace in LEADER, or with `points` the values themselves. The laws aim at
    the mean gap and the mean speed of the recording, and sensors have no error.
    """
    gap_m = np.maximum(convoy.gap[0, 1:], _LEAST_GAP_M) + LENGTH_M
    event: dict[str, Any] = {"type": "trace", "vehicle": 1, "at_s": 0}
    if points:
        event["points"] = [_rounded(pair) for pair in zip(convoy.time_s, convoy.speed[:, 0],
                                                          strict=True)]  # fmt: skip
    else:
        event["file"] = LEADER
    return {
        "description": _description(convoy),
        "duration_s": round(float(convoy.time_s[-1]), 3),
        "road": {"type": "open"},
        "fleet": {
            "size": len(convoy.cars),
            "length_m": LENGTH_M,
            "initial_gaps_m": _rounded(gap_m),
            "initial_speeds_mps": _rounded(convoy.speed[0]),
        },
        "control": {
            "model": "FM",
            "desired_gap_m": round(float(convoy.gap[:, 1:].mean()) + LENGTH_M, 2),
            "desired_speed_mps": round(float(convoy.speed[:, 0].mean()), 2),
        },
        "sensors": {"error": 0},
        "events": [event],
    }


def _description(convoy: Convoy) -> str:
    driven = f", {convoy.setting}" if convoy.setting else ""
    seconds = f"{convoy.time_s[-1]:g} s"
    followers = len(convoy.cars) - 1
    return f"{followers} vehicles behind the leader recorded in {convoy.name}, {seconds}{driven}"


def _rounded(values: Any) -> list[float]:
    return [round(float(value), 4) for value in values]
