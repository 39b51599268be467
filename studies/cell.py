"""A run of a study: a scenario, its changed settings, and a seed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import version

from zenvoy.scenarios import COMMAND_LINE, Loaded, Scenario, Spelling, load


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One run of a study."""

    scenario: str
    seed: int
    settings: tuple[str, ...] = ()
    """Settings of the form `KEY=VALUE`, as on the command line."""
    duration_s: float | None = None
    allow_code: bool = False
    """Whether laws may lie anywhere, not only beside the scenario."""

    def __str__(self) -> str:
        return " ".join((self.scenario, f"seed {self.seed}", *self.settings))

    def load(self, spelling: Spelling = COMMAND_LINE) -> Loaded:
        """Return the scenario of this run; raises ScenarioError."""
        return load(
            self.scenario,
            self.settings,
            seed=self.seed,
            duration_s=self.duration_s,
            allow_code=self.allow_code,
            spelling=spelling,
        )

    def key(self) -> str:
        """Return a key that is equal for cells with the same effective scenario and seed."""
        return key_of(self.load().scenario)


def key_of(scenario: Scenario) -> str:
    """Return a key that is equal for equal scenarios, seed included.

    Default values are left out, so that old runs are still found after a new setting is added.
    """
    values = scenario.model_dump(mode="json", exclude_defaults=True, exclude={"description"})
    text = json.dumps(values, sort_keys=True) + version("zenvoy")
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def grid(
    scenarios: Iterable[str], seeds: Iterable[int], settings: tuple[str, ...] = ()
) -> list[Cell]:
    """Return a cell for each scenario and seed."""
    seeds = list(seeds)
    return [Cell(scenario=s, seed=seed, settings=settings) for seed in seeds for s in scenarios]
