"""`zenvoy new`: write files to start from."""

from __future__ import annotations

import keyword
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Final

import typer

from zenvoy.cli.terminal import console, refuse
from zenvoy.laws import builtin

NEW = typer.Typer(help="Write files to start from.", no_args_is_help=True)

_LAW: Final = '''"""{title}: adaptive cruise control with a constant time gap.

Ioannou and Chien (1993), "Autonomous intelligent cruise control".
"""

from dataclasses import dataclass

from zenvoy.laws import Column, Law, Linear, Observation, Output, Setpoint


@dataclass(frozen=True)
class Parameters:
    """Time gap h (s), gap at standstill (m, from front to front), gain (1/s)."""

    time_gap_s: float = 1.2
    standstill_m: float = 7.0
    gain: float = 0.4


def acceleration(seen: Observation, own: Parameters) -> Output:
    """Return the acceleration of the host, m/s², and the error of its gap, m.

    Use arithmetic only, so that the law takes floats and arrays alike. Instead of `if`, `min` and
    `max`, use `where`, `smaller` and `larger` from zenvoy.laws.
    """
    error = seen.ahead.p - own.standstill_m - own.time_gap_s * seen.speed
    return Output((seen.ahead.v + own.gain * error) / own.time_gap_s, logged=(error,))


def linear(own: Parameters, setpoint: Setpoint, m: int) -> Linear:
    """Return the law linearised at its equilibrium, for the theory in the report."""
    h = own.time_gap_s
    return Linear((1.0,), (), k_d=own.gain / h, k_v=1.0 / h, k_c=own.gain)


{name} = Law(
    name="{title}",
    acceleration=acceleration,
    parameters=Parameters,
    columns=(Column("gap_error", "m"),),
    colour="#CC79A7",
    linear=linear,
)
'''
_TEST: Final = '''"""Tests of the law at points worked out by hand, and in a fleet."""

from pathlib import Path

import numpy as np
import {name}

import zenvoy
from zenvoy.laws import Observation, Relative, Setpoint

SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=30.0)
PARAMETERS = {name}.Parameters(time_gap_s=1.0, standstill_m=5.0, gain=0.5)


def seen(speed, gap, relative_speed=0.0):
    return Observation(speed, SETPOINT, Relative(gap, relative_speed))


def test_the_acceleration_is_zero_in_equilibrium():
    assert {name}.acceleration(seen(20.0, 25.0), PARAMETERS).acceleration == 0.0


def test_a_vehicle_that_is_too_close_brakes():
    assert {name}.acceleration(seen(20.0, 23.0), PARAMETERS).acceleration == -1.0  # 0.5 * -2


def test_arrays_give_the_same_as_numbers():
    gaps = np.array([23.0, 25.0, 40.0])
    one_by_one = [{name}.acceleration(seen(20.0, gap), PARAMETERS).acceleration for gap in gaps]
    as_array = {name}.acceleration(seen(20.0, gaps), PARAMETERS).acceleration
    assert as_array.tolist() == one_by_one


def test_a_fleet_keeps_its_time_gap(tmp_path):
    scenario = Path(__file__).with_name("{name}.yaml")
    run = zenvoy.run(scenario, engine="in-process", out=tmp_path / "run")
    position, speed = run.truth["position"], run.truth["speed"]
    gaps = position[:, :-1] - position[:, 1:]
    assert gaps.min() > 5.0  # the length of a vehicle: there is no collision
    assert abs(gaps[-1, 0] - 7.0 - 1.2 * speed[-1, 1]) < 0.5
'''
_SCENARIO: Final = """description: a fleet under {title} whose leader brakes
duration_s: 60
road: {{type: open}}
fleet: {{size: 6, gap_m: 43, speed_mps: 30}}
control:
  model: "{name}:{name}"
  parameters: {{time_gap_s: 1.2}}
  desired_gap_m: 43
sensors: {{error: 0}}
events: [{{type: brake, vehicle: 1, at_s: 10, duration_s: 3, deceleration_mps2: 2}}]
"""


@NEW.command()
def law(
    name: Annotated[str, typer.Argument(help="Name of the law and of its file.")],
    folder: Annotated[Path, typer.Option(help="Folder to write to.")] = Path(),
) -> None:
    """Write an example of a control law, a scenario that runs it, and a test that passes."""
    if not name.isidentifier() or not name.isascii():
        refuse(f"{name!r} is not the name of a Python module; allowed: letters, digits and _")
    if keyword.iskeyword(name):
        refuse(f"{name!r} is a keyword of Python; allowed: other names")
    if name.replace("_", " ") in builtin():
        refuse(f"{name!r} is a law of Zenvoy; allowed: other names than {', '.join(builtin())}")
    if not (folder / f"{name}.py").exists() and find_spec(name) is not None:
        refuse(
            f"{name!r} is a module that is installed, which its file would hide; allowed: others"
        )
    texts = {f"{name}.py": _LAW, f"test_{name}.py": _TEST, f"{name}.yaml": _SCENARIO}
    for file in texts:
        if (folder / file).exists():
            refuse(f"{folder / file}: exists already")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for file, text in texts.items():
            filled = text.format(name=name, title=name.replace("_", " "))
            (folder / file).write_text(filled, "utf-8")
            console.print(str(folder / file), highlight=False, soft_wrap=True)
    except OSError as error:
        refuse(f"{folder}: {error.strerror}")
