"""Workers of a study fail alone, and a request to end is not lost while one is forked."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Final

import pytest

from tests.fork_strike import children_end_at_once, strike_at_fork
from zenvoy.fleet.requests import REQUESTS_TO_END, interruptible
from zenvoy.studies.cell import Cell
from zenvoy.studies.study import Study, StudyError
from zenvoy.studies.sweeps.workers import each_done

CELLS: Final = [Cell(scenario="quickstart", seed=seed, duration_s=1.0) for seed in (1, 2)]


def _nothing(_task: int) -> None:
    """Do a task."""


@pytest.mark.parametrize("number", REQUESTS_TO_END)
def test_a_request_during_the_fork_of_a_task_ends_the_sweep(number: signal.Signals) -> None:
    with pytest.raises(KeyboardInterrupt), interruptible(), strike_at_fork(number):
        list(each_done(range(3), _nothing, 1))


@pytest.mark.parametrize("number", REQUESTS_TO_END)
def test_a_request_during_the_fork_of_a_worker_ends_the_study(
    tmp_path: Path, number: signal.Signals
) -> None:
    with pytest.raises(KeyboardInterrupt), interruptible(), strike_at_fork(number):
        Study(folder=tmp_path, engine="in-process").run(CELLS)


def test_a_study_reports_workers_that_die_at_once(tmp_path: Path) -> None:
    """Some die while tasks are still handed to them."""
    many = [Cell(scenario="quickstart", seed=seed, duration_s=1.0) for seed in range(1, 301)]
    with pytest.raises(StudyError, match="a process of the study died"), children_end_at_once():
        Study(folder=tmp_path, engine="in-process").run(many)


def _end_itself(_task: int) -> None:
    os.kill(os.getpid(), signal.SIGTERM)


def test_a_worker_unblocks_signals() -> None:
    """Signals are blocked while it is forked."""
    (done,) = each_done([0], _end_itself, 1)
    assert done.failure == "its process was killed by SIGTERM"


def _odd_ones_fail(number: int) -> None:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    if number % 2:
        raise ValueError(f"{number} is odd\nand that is not allowed")


def test_a_task_that_fails_or_dies_affects_no_other() -> None:
    done = {one.task: one.failure for one in each_done(range(6), _odd_ones_fail, 2)}
    assert done == {
        0: None,
        1: "1 is odd and that is not allowed",
        2: None,
        3: "its process was killed by SIGKILL",
        4: None,
        5: "5 is odd and that is not allowed",
    }
