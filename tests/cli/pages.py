"""The pages of the documentation, and which tests run their commands."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from tests.page_commands import Typed

ROOT: Final = Path(__file__).parents[2]
PAGES: Final = [ROOT / "README.md", *sorted(ROOT.glob("docs/*.md"))]

FOLLOWED: Final = {
    "compare-laws.md": "tests/studies/comparison/test_comparison_page.py",
    "extending.md": "tests/cli/test_extending.py",
    "sweeps.md": "tests/studies/test_sweeps_page.py",
    "tuning.md": "tests/studies/test_tuning_page.py",
    "tutorial.md": "tests/cli/test_tutorial.py",
}
"""Pages that a test follows as a story."""

ELSEWHERE: Final = {
    "zenvoy serve": "tests/fleet/test_hosts.py, with hosts of its own",
    "zenvoy join": "tests/fleet/test_hosts.py",
    "zenvoy vehicle": "tests/fleet/test_guests.py and test_locked_doors.py",
    "zenvoy run quickstart --without 7 --listen": "tests/fleet/test_locked_doors.py",
    "zenvoy run quickstart --watch": "tests/cli/test_live_table.py, on a terminal",
    "zenvoy reproduce": "tests/studies/test_study.py, with fewer runs",
    "python -m tests.parity": "tests/parity",
}
"""How commands begin that tests run in their own way: several at a time, or on a terminal."""

NOT_RUN: Final = {
    "zenvoy --install-completion": "writes into the home of the user",
    "python -m benchmarks.": "measures for minutes, on an idle machine",
    "make ": "sets up the environment that runs the tests",
    ". .venv": "is for the shell of the reader",
    "pip install": "changes the environment that runs the tests",
    "cp docs/": "is for the shell of the reader",
    "cd ": "is for the shell of the reader",
    "kill -": "is for a process that the reader sees",
    "jupyter ": "is a program of others",
    "gdb ": "is a program of others",
    "python -m pdb": "talks to a person",
    "(Pdb)": "is typed into a debugger",
    "docker ": "is a program of others",
    "kubectl ": "is a program of others",
    "secret": "is for a cluster",
    "zenohd ": "is a program of others",
}
"""How commands begin that no test runs, and why."""


def begins_as(typed: Typed, starts: Iterable[str]) -> bool:
    """Return whether a command begins as one of these."""
    return " ".join(typed.words).startswith(tuple(starts))
