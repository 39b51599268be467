"""Fixtures of the log that the tests of this folder damage."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.log_surgery import chunks_among, taken_apart
from tests.logs import chunk_every, write_log
from zenvoy.analysis import load
from zenvoy.analysis.log.load import Run

SCENARIO = """
duration_s: 3
seed: 5
fleet: {size: 4}
road: {type: open}
channel: {loss: {p: 0.2}}
control: {model: FM}
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a log of 30 cycles, with a chunk for about every fifth of them."""
    file = tmp_path_factory.mktemp("damaged") / "run.mcap"
    return write_log(file, SCENARIO, clock=chunk_every(5))


@pytest.fixture(scope="module")
def content(path: Path) -> bytes:
    log = path.read_bytes()
    assert len(chunks_among(taken_apart(log))) > 4
    return log


@pytest.fixture(scope="module")
def whole(path: Path) -> Run:
    run = load(path)
    assert run.notes == ()
    assert all(check.holds for check in run.checks), run.checks
    return run
