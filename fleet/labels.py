"""The labels of a run: what its log says about it."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import partial

from zenvoy.bus.clock import stamp
from zenvoy.bus.log_metadata import RunMetadata
from zenvoy.bus.scene import Stage
from zenvoy.bus.text import utf8
from zenvoy.links.distance import gaps
from zenvoy.scenarios import Loaded, Scenario, effective_json, own_laws
from zenvoy.world.recorder import Labels, metadata_of


def labels_of(loaded: Loaded, bus: str, per_process: int) -> Labels:
    """Return the labels that the log of this run will have."""
    scenario = loaded.scenario
    return Labels(
        scenario_name=utf8(loaded.name).decode(),  # a file name may not be valid UTF-8
        scenario_text=loaded.text,
        effective_json=effective_json(scenario),
        seed=scenario.seed,
        cycles=scenario.cycles,
        period_ns=scenario.period_ns,
        vehicles=scenario.fleet.size,
        bus=bus,
        run=f"{stamp()}-{os.getpid()}",
        per_process=per_process,
        # Paths are left out: a log must not reveal whose machine it was made on.
        laws=own_laws(scenario),
        notes=tuple(utf8(str(replace(note, place=None))).decode() for note in loaded.notes),
        stage=stage_of(scenario) if scenario.log.scene else None,
    )


def stage_of(scenario: Scenario) -> Stage:
    """Return what a scene of this scenario shows."""
    return Stage(
        vehicles=scenario.fleet.size,
        ring_length_m=scenario.ring_length_m,
        gaps_of=partial(gaps, ring_length_m=scenario.ring_length_m),
        vehicle_length_m=scenario.fleet.length_m,
        fast_mps=max(scenario.control.desired_speed_mps, *scenario.fleet.speeds_at_start_mps, 1.0),
    )


def metadata_without_log(loaded: Loaded) -> RunMetadata:
    """Return the record zenvoy.run that a log would have, for a run on arrays without a log."""
    return metadata_of(labels_of(loaded, "arrays", loaded.scenario.fleet.size))
