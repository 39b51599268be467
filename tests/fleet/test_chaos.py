"""A sample of `make chaos`: cases have a victim, a signal, a kind of run and a moment."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

from tests.chaos.cases import Case, all_kinds
from tests.chaos.ends import expected_of
from tests.chaos.found import Found, table
from tests.chaos.trial import try_case

# One of each victim and signal, over all kinds of runs and moments. A stall takes its limit.
SAMPLE: Final = [
    ("vehicle", "KILL", "shared", "middle"),
    ("vehicle", "TERM", "each", "middle"),
    ("vehicle", "TERM", "realtime", "start"),
    ("vehicle", "INT", "shared", "middle"),
    ("vehicle", "STOP 3 s", "realtime", "middle"),
    ("vehicle", "STOP", "each", "start"),
    ("channel", "KILL", "realtime", "last"),
    ("channel", "TERM", "realtime", "middle"),
    ("channel", "HUP", "each", "start"),
    ("channel", "STOP", "realtime", "middle"),
    ("world", "KILL", "each", "middle"),
    ("world", "TERM", "realtime", "last"),
    ("world", "TERM", "shared", "start"),
    ("world", "STOP 3 s", "each", "last"),
    ("command", "KILL", "shared", "start"),
    ("command", "TERM", "realtime", "middle"),
    ("command", "HUP", "each", "middle"),
    ("command", "STOP 3 s", "shared", "middle"),
]
# The time that an end takes depends on the load of the machine, so only `make chaos` judges it.
_TIMING: Final = ("took ", " are lost")


@pytest.mark.parametrize("what", SAMPLE, ids=", ".join)
def test_a_run_ends_as_documented(tmp_path: Path, what: tuple[str, str, str, str]) -> None:
    victim, blow, mode, moment = what
    found = try_case(Case(victim=victim, blow=blow, mode=mode, moment=moment), tmp_path / "case")
    assert [one for one in found.wrong if not any(word in one for word in _TIMING)] == []


def test_every_kind_of_case_has_a_documented_end() -> None:
    kinds = all_kinds()
    assert len(kinds) == 4 * 6 * 3 * 3
    assert all(expected_of(kind).ends for kind in kinds)


def test_the_table_counts_wrong_ends() -> None:
    case = Case(victim="world", blow="KILL", mode="each", moment="middle")
    results = [Found(case, code=3, took_s=0.5), Found(case, ["no log"], code=0, lost_s=0.25)]
    (row,) = table(results).splitlines()[1:]
    assert row.split() == ["world", "KILL", "each", "2", "0.50", "0.25", "1", "0:", "1,", "3:", "1"]
