"""Turns fitted numbers into groups of a scenario: one group for each car."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from zenvoy.laws import builtin
from zenvoy.scenarios import name_of
from zenvoy.scenarios.convoys.scenario_of import values_of
from zenvoy.studies.convoys.calibration import Calibration
from zenvoy.studies.convoys.fitting import Task


def scenario_values(found: Calibration, folder: Path | None = None) -> dict[str, Any]:
    """Return the values of the convoy's scenario, each follower driven by its fitted law.

    folder: where the scenario will lie, from which a file of the law is named.
    """
    values = values_of(found.convoy)
    groups = [
        group_of(found.task, fit.values, name=name, vehicles=vehicle, folder=folder)
        for vehicle, (fit, name) in enumerate(
            zip(found.fits, names_of([fit.car for fit in found.fits]), strict=True), start=2
        )
    ]
    values["description"] = f"{values['description']}; {found.law.name} fitted to each"
    values["fleet"]["groups"] = groups
    return values


def group_of(
    task: Task, values: Mapping[str, float], *, name: str, vehicles: int | str, folder: Path | None
) -> dict[str, Any]:
    """Return a group of vehicles with a fitted law."""
    rounded = {key: float(f"{value:.6g}") for key, value in values.items()}
    parameters = {one.name: rounded[one.name] for one in task.free if one.of == "law"}
    gains = {name: rounded[name] for name in ("k_d", "k_v", "k_c") if name in rounded}
    group: dict[str, Any] = {"name": name, "vehicles": vehicles}
    group["model"] = _reference(task.model, folder)
    group |= {"parameters": parameters} if parameters else {}
    group |= {"gains": gains} if gains else {}
    if "desired_gap_m" in rounded:
        group["desired_gap_m"] = rounded["desired_gap_m"]
    return group


def names_of(cars: list[str]) -> list[str]:
    """Return a name for the group of each car, all of them different words."""
    names: list[str] = []
    for car in cars:
        word = re.sub(r"\W+", "_", car, flags=re.ASCII).strip("_") or "car"
        word = word if word[0].isalpha() else f"car_{word}"
        number = sum(name == word or name.startswith(f"{word}_no") for name in names)
        names.append(f"{word}_no{number + 1}" if number else word)
    return names


def _reference(model: str, folder: Path | None) -> str:
    """Return how a scenario in a folder names a model; its own file by the path from there."""
    name = name_of(model)
    file, _, attribute = name.rpartition(":")
    if model in builtin() or folder is None or not file.endswith(".py"):
        return name
    return f"{os.path.relpath(file, folder)}:{attribute}"
