"""The pages of the documentation with commands, and which tests run these."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from tests.page_commands import Typed

ROOT: Final = Path(__file__).parents[2]
PAGES: Final = [ROOT / "README.md", *sorted(ROOT.glob("docs/*.md"))]

# Pages that a test follows, or whose commands go on side by side in a test of their own.
FOLLOWED: Final = {
    "compare-laws.md": "tests/studies/comparison/test_comparison_page.py",
    "extending.md": "tests/cli/test_extending.py",
    "external-vehicle.md": "tests/fleet/test_guests.py",
    "recipes.md": "tests/examples/test_deploy.py",
    "several-hosts.md": "tests/fleet/test_hosts.py",
    "sweeps.md": "tests/studies/test_sweeps_page.py",
    "tuning.md": "tests/studies/test_tuning_page.py",
    "tutorial.md": "tests/cli/test_tutorial.py",
}
# What a test cannot run inside a test, or only at the cost of minutes, and where it is run.
ELSEWHERE: Final = {
    "make ": ".ci/run, and the commands that the Makefile has for the demo",
    ". .venv": "activates an environment",
    "pip install": "changes the environment of the tests",
    "python -m tests.parity": "tests/parity",
    "python -m benchmarks.": "measures, by hand, on an idle machine",
    "zenvoy --install-completion": "tests/cli/test_usage.py",
    "python -m examples.neighbourhood": "tests/examples",
    "zenvoy run quickstart --watch": "tests/cli/test_live_table.py, on a terminal",
    "zenvoy reproduce": "tests/studies",
    "zenvoy mixed-traffic": "tests/studies/mixed",
}


def is_run_elsewhere(typed: Typed, starts: Iterable[str] = ELSEWHERE) -> bool:
    """Return whether a command begins as one of these."""
    return " ".join(typed.words).startswith(tuple(starts))
