"""Runs a scenario from Python."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from operator import index
from os import PathLike
from pathlib import Path
from typing import Literal, SupportsIndex

from pydantic import ValidationError

from zenvoy import errors
from zenvoy.analysis.log.arrays import as_json
from zenvoy.bus.text import utf8
from zenvoy.fleet.choice import EngineError, choose
from zenvoy.fleet.ends import Death, shortage_of
from zenvoy.fleet.engine import CHOICES, Choice
from zenvoy.fleet.folder import LOG, SUMMARY, FolderError, make_folder
from zenvoy.fleet.per_process import PerProcessError, per_process_of
from zenvoy.fleet.progress import Progress
from zenvoy.fleet.run import Watch
from zenvoy.fleet.run import run as run_in
from zenvoy.result import Run, load
from zenvoy.scenarios import Loaded, Scenario, effective_json, effective_yaml
from zenvoy.settings import loaded
from zenvoy.values.section import SEED_LIMIT

__all__ = ["Progress", "run"]


def run(
    scenario: str | PathLike[str] | Loaded | Scenario,
    *,
    seed: SupportsIndex | None = None,
    engine: Choice = "processes",
    vehicles_per_process: int | Literal["auto"] = 1,
    out: str | PathLike[str] | None = None,
    on_progress: Callable[[Progress], None] | None = None,
) -> Run:
    """Run a scenario to its end, and return the run as logged.

    `scenario` is the name of a built-in scenario, a file, or a value returned by `zenvoy.scenario`;
    `seed` replaces its seed. `engine` is "processes" (a process per vehicle on Zenoh),
    "in-process" (all vehicles in this process, which is faster for a small fleet), "arrays" (the
    same arithmetic on arrays, which is faster still, but does not run every scenario) or "auto"
    ("arrays" where they run the scenario, else "in-process"). All write the same log, bit for bit.
    `vehicles_per_process` is the number of neighbours that share a process; with "auto" there is a
    process for each processor. `out` is the folder of the run, new or empty; by default it is
    `runs/<time>-<scenario>`. `on_progress` is called several times a second, in this thread; an
    exception that it raises ends the run.

    Nothing is printed. Ctrl-C raises KeyboardInterrupt, and the log so far is kept. The processes
    are forked from this one, which must not have opened a Zenoh session before.

    Raises ScenarioError, FolderError, InputError for an engine that is unknown or does not run the
    scenario, ProcessLostError if a process dies or stalls, and RunError if the system lacks disk,
    memory, processes or file descriptors for the run.
    """
    what = _seeded(scenario, _whole(seed))
    if engine not in CHOICES:
        raise errors.InputError(f"engine: {engine!r} is not one of {', '.join(CHOICES)}")
    if what.scenario.clock == "realtime" and engine != "processes":
        raise errors.InputError('clock: realtime needs processes; allowed: engine="processes"')
    try:
        per_process = per_process_of(vehicles_per_process, what.scenario.fleet.size)
    except PerProcessError as error:
        raise errors.InputError(f"vehicles_per_process: {error}") from error
    if per_process > 1 and engine != "processes":
        text = 'vehicles_per_process needs processes; allowed: engine="processes"'
        raise errors.InputError(text)
    try:
        chosen = choose(engine, what.scenario)
    except EngineError as error:
        raise errors.InputError(str(error)) from error
    try:
        folder = make_folder(None if out is None else Path(out), what.name)
    except FolderError as error:
        raise errors.FolderError(f"out: {error}") from error
    log = folder / LOG
    watch = Watch() if on_progress is None else Watch(on_progress=on_progress)
    try:
        death = run_in(what, folder, chosen.engine, watch, per_process=per_process)
        if death is not None and not death.complete:
            raise _lost(death, log)
        done = load(log)
        (folder / SUMMARY).write_bytes(utf8(as_json(done.summary)))
    except OSError as error:  # a full disk, too few processes or file descriptors
        raise errors.RunError(f"the run cannot go on: {shortage_of(error)}", _kept(log)) from error
    return done


def _seeded(scenario: str | PathLike[str] | Loaded | Scenario, seed: int | None) -> Loaded:
    if isinstance(scenario, Scenario):
        text = effective_yaml(scenario)
        scenario = Loaded(name="scenario", scenario=scenario, text=text)
    if not isinstance(scenario, Loaded):
        return loaded(scenario, {}, seed)
    if seed is None:
        return scenario
    values = {**json.loads(effective_json(scenario.scenario)), "seed": seed}
    try:
        return replace(scenario, scenario=Scenario.model_validate(values))
    except ValidationError as error:
        raise errors.ScenarioError(f"seed: {seed} is not in [0, {SEED_LIMIT})") from error


def _whole(seed: object) -> int | None:
    """Return a seed as Python's int, also from an integer of numpy."""
    if seed is None:
        return None
    if isinstance(seed, SupportsIndex) and not isinstance(seed, bool):
        return index(seed)
    raise errors.ScenarioError(f"seed: {seed!r} is not a whole number")


def _lost(death: Death, log: Path) -> errors.RunError:
    if death.refused:
        return errors.RunError(str(death), _kept(log))
    return errors.ProcessLostError(str(death), _kept(log), death.name, death.tail)


def _kept(log: Path) -> Path | None:
    return log if log.exists() else None
