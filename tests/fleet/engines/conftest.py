"""A folder with a scenario whose laws are its own, some of which arrays do not run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import pytest

LAW: Final = '''\
"""Follows the vehicle ahead, and remembers how far it was from its desired gap."""

from dataclasses import dataclass

from zenvoy.laws import Column, Law, Output, clipped, where


@dataclass(frozen=True)
class Parameters:
    gain: float = 0.1
    breaks_at: float = 1e9


def acceleration(seen, own):
    cycles, integral = seen.state
    error = seen.ahead.p - seen.setpoint.p_des
    integral = integral + error * seen.period_s
    k_d = where(error < 0.0, 2.0 * own.gain, own.gain)
    a = k_d * error + 0.5 * seen.ahead.v + clipped(0.01 * integral, 0.2)
    a = a + 0.01 * (seen.uniform(0) - 0.5)
    late = 1.0 / (cycles - own.breaks_at)
    return Output(a + 0.0 * late, logged=(error, late), state=(cycles + 1.0, integral))


LAW = Law(
    name="Remembering",
    acceleration=acceleration,
    parameters=Parameters,
    columns=(Column("gap_error", "m"), Column("late", "1")),
    state=(0.0, 0.0),
)


def branching(seen, own):
    if seen.ahead.p < 20.0:
        return -1.0
    return 0.1 * seen.ahead.v


BRANCHING = Law(name="branching", acceleration=branching)


def picky(seen, own):
    if getattr(seen.speed, "shape", None) == (2,):
        raise ValueError("not\\ntwo")
    return 0.1 * seen.ahead.v


PICKY = Law(name="picky", acceleration=picky)


class Ended(BaseException):
    pass


def ending(seen, own):
    raise Ended("for good")


ENDING = Law(name="ending", acceleration=ending)
'''
OWN: Final = """
duration_s: 6
road: {type: open}
fleet: {size: 3, speed_mps: 28}
control: {model: "pi:LAW", desired_speed_mps: 28}
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make the current folder one with a scenario and its own laws, and return it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pi.py").write_text(LAW)
    (tmp_path / "own.yaml").write_text(OWN)
    return tmp_path


def summary(folder: Path) -> dict[str, Any]:
    """Return the summary that `zenvoy run` writes beside the log."""
    found: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return found
