"""The commands that list, show, check and describe scenarios.

Each command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

import sys

from rich.table import Table

from zenvoy.cli.options import (
    AllowCodeOption,
    DurationOption,
    ScenarioArgument,
    SeedOption,
    SetOption,
    StrictOption,
    print_notes,
    scenario_of,
)
from zenvoy.cli.terminal import console, say
from zenvoy.scenarios import builtin, effective_yaml


def scenarios() -> None:
    """List the built-in scenarios."""
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, description in builtin():
        table.add_row(name, description)
    console.print(table)


def show(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    seed: SeedOption = None,
    duration_s: DurationOption = None,
    allow_code: AllowCodeOption = False,
) -> None:
    """Print a scenario with all its defaults.

    The output is a valid scenario file.
    """
    shown = scenario_of(scenario, overrides, seed, duration_s, allow_code=allow_code).scenario
    # A scenario file is UTF-8. On a terminal of another encoding, print ASCII alone.
    utf = sys.stdout.encoding.lower().startswith("utf")
    sys.stdout.write(effective_yaml(shown, ascii_only=not utf))


def check(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    strict: StrictOption = False,
    allow_code: AllowCodeOption = False,
) -> None:
    """Check a scenario and print all its errors.

    Also says whether the array engine runs it.
    """
    loaded = scenario_of(scenario, overrides, None, None, allow_code=allow_code)
    print_notes(loaded, strict)
    size, duration_s = loaded.scenario.fleet.size, loaded.scenario.duration_s
    say(f"{loaded.name}: valid; {size} vehicles, {duration_s:g} s")
    from zenvoy.fleet.arrays.covered import uncovered

    for line in uncovered(loaded.scenario) or ["runs on arrays"]:
        say(line)


def schema() -> None:
    """Print the JSON Schema of scenario files, for editors.

    With it an editor completes keys, explains them and marks errors while you write.
    """
    import json

    from zenvoy.scenarios.reading.editor_schema import editor_schema

    sys.stdout.write(json.dumps(editor_schema(), indent=1) + "\n")


SCENARIO_COMMANDS = (scenarios, show, check, schema)
