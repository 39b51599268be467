"""Loads a scenario by path or name: reads it, applies overrides and validates it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.reading.extends import chain
from zenvoy.scenarios.reading.files import with_files
from zenvoy.scenarios.reading.laws import require_linear_forms, with_laws
from zenvoy.scenarios.reading.library import packaged
from zenvoy.scenarios.reading.origin import located
from zenvoy.scenarios.reading.overrides import overridden
from zenvoy.scenarios.reading.spacing import with_spacing
from zenvoy.scenarios.reading.spelling import COMMAND_LINE, Spelling
from zenvoy.scenarios.reading.validate import placed, validated
from zenvoy.scenarios.schema.notes import notes_of
from zenvoy.scenarios.schema.scenario import Scenario


@dataclass(frozen=True, slots=True, kw_only=True)
class Loaded:
    """A scenario, checked and ready to run, as `zenvoy.scenario` returns it."""

    name: str
    """The name of the scenario: that of a built-in one, or of its file without the suffix."""
    scenario: Scenario
    """All values of the scenario, with changes and defaults, such as `scenario.fleet.size`."""
    text: str
    """The text of its own file, without the files that it extends and without changes."""
    notes: tuple[Problem, ...] = ()
    """Settings that are allowed but probably a mistake, each with its key, text and place."""


def load(
    name_or_path: str | Path,
    overrides: Sequence[str] = (),
    *,
    seed: int | None = None,
    duration_s: float | None = None,
    clock: str | None = None,
    speed: float | None = None,
    allow_code: bool = False,
    spelling: Spelling = COMMAND_LINE,
) -> Loaded:
    """Return the scenario in an existing file, or else the built-in one of that name.

    overrides have the form `key=value` with a dotted key and a value in YAML (channel.loss.p=0.3);
    seed, duration_s, clock and speed apply after them. The code of a law that the scenario names
    must lie beside the scenario or in an installed package, unless `allow_code`.
    `spelling` is that of overrides and options in messages. Raises
    UnknownScenarioError, UnreadableScenarioError or InvalidScenarioError, each a ScenarioError.
    """
    origin = located(name_or_path)
    files = chain(origin)
    options = {"seed": seed, "duration_s": duration_s, "clock": clock, "speed": speed}
    root, in_overrides = overridden(files.root, overrides, options, spelling)
    root, in_spacing = with_spacing(root)
    root, errors = with_files(root, files.origins)
    root, in_laws = with_laws(
        root, files.origins, allow_code=allow_code, to_allow=spelling.allow_code
    )
    scenario = validated(root, [*files.problems, *in_overrides, *in_spacing, *in_laws], errors)
    require_linear_forms(scenario, root)
    notes = tuple(sorted(placed(notes_of(scenario), root), key=lambda note: note.order))
    return Loaded(name=origin.name, scenario=scenario, text=files.text, notes=notes)


def builtin() -> list[tuple[str, str]]:
    """Return the name and description of every built-in scenario, in order of name."""
    return [(name, load(name).scenario.description) for name in packaged()]
