"""A convoy whose followers have a law with known numbers, as the engine drives them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from zenvoy.analysis.log.load import load as load_log
from zenvoy.fleet.folder import LOG, make_folder
from zenvoy.fleet.run import run
from zenvoy.scenarios import Loaded, Scenario, effective_yaml
from zenvoy.scenarios.convoys.convoy import Convoy, Floats

LENGTH_M = 5.0


def scenario_of(control: Mapping[str, Any], **changes: Any) -> Scenario:
    """Return two followers behind a leader that swings and brakes, without sensor errors."""
    values = {
        "duration_s": 40,
        "road": {"type": "open"},
        "fleet": {"size": 3, "gap_m": 25.0, "speed_mps": 15.0},
        "control": {"desired_gap_m": 25.0, "desired_speed_mps": 15.0, **control},
        "sensors": {"error": 0.0},
        "events": [
            {"type": "sine", "vehicle": 1, "at_s": 1.0, "duration_s": 20.0, "mean_mps": 15.0,
             "amplitude_mps": 2.0, "frequency_hz": 0.1},
            {"type": "brake", "vehicle": 1, "at_s": 25.0, "duration_s": 3.0,
             "deceleration_mps2": 2.0, "return_s": 6.0},
        ],
        **changes,
    }  # fmt: skip
    return Scenario.model_validate(values)


def convoy_of(scenario: Scenario, folder: Path) -> Convoy:
    """Return the fleet of a run in process as if it had been recorded."""
    loaded = Loaded(name="made", scenario=scenario, text=effective_yaml(scenario))
    run(loaded, make_folder(folder, "made"), "in-process")
    true = load_log(folder / LOG).truth
    gap = np.full(true["position"].shape, np.nan)
    gap[:, 1:] = -np.diff(true["position"], axis=1) - scenario.fleet.length_m
    time_s: Floats = np.arange(float(len(gap))) * scenario.period_ns * 1e-9
    return Convoy(
        name=folder.name,
        cars=("LEAD", "CAR_A", "CAR_B"),
        time_s=time_s,
        speed=true["speed"],
        gap=gap,
    )
