"""A folder with laws of a user and a scenario of them, and a run of that scenario."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.idm import IDM
from tests.logs import write_log
from zenvoy.analysis.log.load import Run, load

# A law with every feature: both sides, a state, columns, a linear form, random numbers.
RICH = """
from dataclasses import dataclass

from zenvoy.laws import Column, Law, Linear, Needs, Output


@dataclass(frozen=True)
class Parameters:
    share: float = 0.5
    noise: float = 0.0


def balance(seen, p):
    k_d, k_v, k_c, _, v_des = seen.setpoint
    pull = k_d * (seen.ahead.p - p.share * seen.behind.p - (1.0 - p.share) * seen.setpoint.p_des)
    damp = k_v * (seen.ahead.v - p.share * seen.behind.v)
    (decisions,) = seen.state
    luck = seen.uniform(0)
    a = pull + damp + k_c * (v_des - seen.speed) + p.noise * (luck - 0.5)
    return Output(a, logged=(decisions, luck), state=(decisions + 1.0,))


def linear(p, setpoint, m):
    return Linear((1.0,), (p.share,), setpoint.k_d, setpoint.k_v, setpoint.k_c)


LAW = Law(
    name="Rich",
    acceleration=balance,
    parameters=Parameters,
    needs=Needs(behind=True),
    columns=(Column("decisions"), Column("luck")),
    state=(0.0,),
    linear=linear,
)
"""
MIXED = """
duration_s: 6
fleet:
  size: 6
  groups: [{name: odd, vehicles: "1,3", model: "rich:LAW", parameters: {noise: 0.5}}]
control:
  model: FM
  schedule: [{at_s: 2, model: "idm:smith", vehicles: "5-6", parameters: {headway_s: 0.9}}]
channel: {outages: [{from_s: 3, until_s: 5}], loss: {p: 0.1}}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""


@pytest.fixture
def laws(tmp_path: Path) -> Path:
    (tmp_path / "idm.py").write_text(IDM)
    (tmp_path / "rich.py").write_text(RICH)
    (tmp_path / "mixed.yaml").write_text(MIXED)
    return tmp_path


@pytest.fixture
def mixed(laws: Path) -> Run:
    return load(write_log(laws / "run.mcap", MIXED))
