"""Laws of a user give the same bits on processes and in one process, and start afresh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import zenvoy
from tests.laws.own_laws.conftest import MIXED
from tests.logs import write_log
from zenvoy.analysis.log.load import Run, load


@pytest.mark.parametrize("per_process", [1, 3])
def test_processes_and_one_process_give_the_same_bits(
    laws: Path, mixed: Run, per_process: int
) -> None:
    outcome = zenvoy(
        laws, "run", "mixed.yaml", "--out", "out", "--vehicles-per-process", str(per_process)
    )
    assert outcome.code == 0, outcome.err
    assert load(laws / "out" / "run.mcap").fingerprint == mixed.fingerprint is not None


def test_a_law_that_takes_over_starts_afresh(mixed: Run) -> None:
    """Its state counts the decisions since it took over, and starts again after the outage."""
    counted = mixed.estimate["Rich.decisions"][:, 0]
    starts = np.flatnonzero(counted == 0.0)
    assert len(starts) >= 2
    for start in starts:
        end = start + 5
        assert counted[start:end].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_random_numbers_depend_on_the_seed_alone(laws: Path, mixed: Run) -> None:
    again = load(write_log(laws / "again.mcap", MIXED))
    other = load(write_log(laws / "other.mcap", f"seed: 2\n{MIXED}"))
    assert again.fingerprint == mixed.fingerprint
    assert not np.array_equal(
        other.estimate["Rich.luck"][:5, 0], mixed.estimate["Rich.luck"][:5, 0]
    )
