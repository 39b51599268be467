"""The best trial as a scenario that runs without changes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from zenvoy.bus.text import utf8
from zenvoy.scenarios import Scenario, ScenarioError, effective_yaml, load
from zenvoy.scenarios.schema.effective import as_yaml
from zenvoy.studies.cell import Cell
from zenvoy.studies.tuning.study import TuneStudy
from zenvoy.studies.tuning.trial import Trial
from zenvoy.values.wording import one_line


def best_yaml(study: TuneStudy, best: Trial, folder: Path) -> bytes | None:
    """Return the text of a scenario file in `folder` that is the best trial with its first seed.

    It extends the study's scenario if that is possible; else it has every value. The result is None
    if neither gives the same scenario, such as for a law whose file lies elsewhere.
    """
    cell = cell_of(study, best)
    wanted = cell.load().scenario
    what = one_line(f"{study.name}: {best.told(study)}")
    head = f"# Trial {best.number}, the best of the study {what}\n"
    texts = [head + _extension(cell, wanted, folder), head + effective_yaml(wanted)]
    return next(
        (utf8(text) for text in texts if _loaded(text, folder, study.allow_code) == wanted), None
    )


def cell_of(study: TuneStudy, trial: Trial) -> Cell:
    """Return the run of a trial with its first seed."""
    return Cell(
        scenario=study.runs.scenario,
        seed=study.seeds[0],
        settings=(*study.runs.settings, *trial.as_settings),
        duration_s=study.runs.duration_s,
        allow_code=study.allow_code,
    )


def _extension(cell: Cell, wanted: Scenario, folder: Path) -> str:
    base = cell.scenario
    if Path(base).is_file():
        base = os.path.relpath(base, folder)
    values: dict[str, Any] = {"extends": base}
    whole = wanted.model_dump(mode="json")
    for setting in cell.settings:
        key, _, text = setting.partition("=")
        _put(values, key.strip().split("."), _parsed(text), whole)
    values["seed"] = cell.seed
    if cell.duration_s is not None:
        values["duration_s"] = cell.duration_s
    return as_yaml(values)


def _put(values: dict[str, Any], path: list[str], value: Any, whole: Any) -> None:
    """Put a value at a path; write a list on the way as a whole, because lists are replaced."""
    first, *rest = path
    inside = whole.get(first) if isinstance(whole, dict) else None
    if not rest:
        values[first] = value
    elif isinstance(inside, list):
        values[first] = inside
    else:
        under = values.setdefault(first, {})
        if isinstance(under, dict):
            _put(under, rest, value, inside)


def _parsed(text: str) -> Any:
    try:
        return YAML(typ="safe", pure=True).load(text)
    except YAMLError:
        return text


def _loaded(text: str, folder: Path, allow_code: bool) -> Scenario | None:
    """Return the scenario that this text would be as a file in the folder; None if it is none."""
    path = folder / f".best.{os.getpid()}.yaml"
    try:
        path.write_bytes(utf8(text))
        return load(path, allow_code=allow_code).scenario
    except ScenarioError:
        return None
    finally:
        path.unlink(missing_ok=True)
