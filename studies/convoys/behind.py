"""Drives laws behind the leader of a recorded convoy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, NamedTuple

import numpy as np

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.log.load import load as load_log
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import TRUTH
from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.fleet.folder import LOG, make_folder
from zenvoy.fleet.run import run
from zenvoy.scenarios import Loaded, Scenario, effective_yaml
from zenvoy.scenarios.convoys.convoy import Convoy, Floats
from zenvoy.scenarios.convoys.scenario_of import values_of
from zenvoy.studies.batches import run_batch

LEAD_IN_S: Final = 120.0
_COLUMNS: Final = {TRUTH.log_name: ("position", "speed")}


class Motion(NamedTuple):
    """Speed (T, n), m/s, and gap from bumper to bumper (T, n - 1), m, of vehicles; collisions."""

    speed: Floats
    gap: Floats
    collisions: int


def motions(values: Mapping[str, Any], seeds: Sequence[int] = (1,)) -> list[Motion]:
    """Return the motion of a scenario's fleet for each seed, from arrays where they run it."""
    scenarios = [Scenario.model_validate({**values, "seed": seed}) for seed in seeds]
    loaded = [Loaded(name="convoy", scenario=one, text=effective_yaml(one)) for one in scenarios]
    return [_motion(run, scenarios[0].fleet.length_m) for run in _runs(loaded)]


def under(
    convoy: Convoy, model: str, parameters: Mapping[str, float] | None = None
) -> dict[str, Any]:
    """Return the values of the convoy's scenario with a law for all followers."""
    values = values_of(convoy, points=True)
    values["control"] |= {"model": model} | ({"parameters": parameters} if parameters else {})
    return values


def settled(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a convoy's scenario with a lead-in, after which its law has settled.

    The leader first keeps the speed with which it begins. The others start evenly spaced, so that
    what follows is the answer to the leader alone.
    """
    fleet, control = values["fleet"], values["control"]
    size, first_mps = fleet["size"], fleet["initial_speeds_mps"][0]
    return {
        **values,
        "duration_s": values["duration_s"] + LEAD_IN_S,
        "fleet": {
            **fleet,
            "initial_gaps_m": [control["desired_gap_m"]] * (size - 1),
            "initial_speeds_mps": [first_mps] * size,
        },
        "events": [{**event, "at_s": LEAD_IN_S} for event in values["events"]],
    }


def after_lead_in(motion: Motion, period_s: float) -> Motion:
    """Return what a settled convoy does behind the recorded leader."""
    rows = slice(round(LEAD_IN_S / period_s), None)
    return motion._replace(speed=motion.speed[rows], gap=motion.gap[rows])


def recorded(convoy: Convoy) -> Motion:
    """Return the motion of the cars themselves."""
    return Motion(convoy.speed, convoy.gap[:, 1:], 0)


def _runs(loaded: Sequence[Loaded]) -> Iterator[Run]:
    if not uncovered(loaded[0].scenario):
        yield from run_batch(loaded, _COLUMNS)
        return
    for one in loaded:
        with TemporaryDirectory(prefix="zenvoy-") as folder:
            run(one, make_folder(Path(folder) / "run", one.name), "in-process")
            yield load_log(Path(folder) / "run" / LOG)


def _motion(run: Run, length_m: float) -> Motion:
    position = run.truth["position"]
    gap = -np.diff(position, axis=1) - length_m
    collisions = sum(event.kind == pb.EVENT_COLLISION for event in run.events)
    return Motion(np.asarray(run.truth["speed"]), np.asarray(gap), collisions)
