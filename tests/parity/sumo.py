"""Runs SUMO's car-following model CC, which has Plexe's controllers.

Parameters have the names of SUMO's `CC_Const.h`. As in Plexe, every vehicle gets the state of the
leader and of the vehicle ahead with each beacon; its radar is SUMO's. libsumo is one simulation per
process and may end it, so it has a process of its own.
"""

from __future__ import annotations

import contextlib
import io
import math
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import TypeAdapter

from tests.as_child import as_child
from tests.parity.cases import (
    BEACON_STEPS,
    BRAKES_AT_S,
    BRAKING_MPS2,
    COMFORTABLE_MPS2,
    DURATION_S,
    FREE_MPS2,
    LAG_S,
    LAWS,
    LENGTH_M,
    PLAN,
    SIZE,
    SPEED_MPS,
    STEP_S,
    Case,
    Law,
    Limited,
    Manoeuvre,
    Motion,
    wanted_mps,
)

ROOT: Final = Path(__file__).parents[2]
_MANOEUVRE: Final = TypeAdapter[Manoeuvre](Manoeuvre).validate_python
_LIMITED: Final = TypeAdapter[Limited](Limited).validate_python
_ACC: Final = 1
_ROAD_M: Final = 20_000.0
_FIRST_M: Final = 1_000.0
_VEHICLES: Final = [str(number) for number in range(1, SIZE + 1)]
_NET: Final = f"""\
<net version="1.20">
    <location netOffset="0,0" convBoundary="0,0,{_ROAD_M},0" origBoundary="0,0,{_ROAD_M},0"
        projParameter="!"/>
    <edge id="road" from="a" to="b" priority="1">
        <lane id="road_0" index="0" speed="60" length="{_ROAD_M}" shape="0,-1.6 {_ROAD_M},-1.6"/>
    </edge>
    <junction id="a" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,0 0,-3.2"/>
    <junction id="b" type="dead_end" x="{_ROAD_M}" y="0" incLanes="road_0" intLanes=""
        shape="{_ROAD_M},0"/>
</net>
"""
_TYPE: Final = (
    f'<vType id="{{name}}" length="{LENGTH_M}" minGap="0" maxSpeed="60" sigma="0" accel="{{limit}}"'
    f' decel="{{limit}}" carFollowModel="CC" tau="{LAG_S}" lanesCount="1" ccAccel="{{cruise}}"'
    ' ccDecel="{cruise}"/>'
)


def motions(laws: Sequence[Law], manoeuvre: Manoeuvre, limited: Limited) -> list[Motion]:
    """Return the motion under each law, from a process that ends afterwards."""
    names = [law.name for law in laws]
    with tempfile.TemporaryDirectory(prefix="zenvoy-parity-") as folder:
        out = Path(folder, "motions.npy")
        command = [sys.executable, "-m", "tests.parity.sumo", str(out), manoeuvre, limited, *names]
        subprocess.run(as_child(*command), check=True, cwd=ROOT)
        return [Motion(both[:, : SIZE - 1], both[:, SIZE - 1 :]) for both in np.load(out)]


def main(out: str, manoeuvre: str, limited: str, *names: str) -> None:
    """Run laws, and save their motions: laws, steps, gaps and speeds."""
    case = partial(Case, manoeuvre=_MANOEUVRE(manoeuvre), limited=_LIMITED(limited))
    laws = [law for name in names for law in LAWS if law.name == name]
    np.save(out, [np.hstack(_motion(case(law))) for law in laws])


def _motion(case: Case) -> Motion:
    with contextlib.redirect_stdout(io.StringIO()):  # it warns of the version of pyarrow
        sumo: Any = import_module("libsumo")
    with tempfile.TemporaryDirectory(prefix="zenvoy-parity-") as folder:
        net, routes = Path(folder, "net.xml"), Path(folder, "routes.xml")
        net.write_text(_NET)
        routes.write_text(_routes(case))
        options = ["--step-length", str(STEP_S), "--collision.action", "none"]
        quiet = ["--no-step-log", "--no-warnings"]
        sumo.start(["sumo", "-n", str(net), "-r", str(routes), *options, *quiet])
        try:
            _place(sumo.vehicle, sumo.simulationStep, case)
            return _driven(sumo.vehicle, sumo.simulationStep, case)
        finally:
            sumo.close()


def _routes(case: Case) -> str:
    limit = BRAKING_MPS2 if case.limited == "engines" else FREE_MPS2
    leader = _TYPE.format(name="leader", limit=limit, cruise=COMFORTABLE_MPS2)
    follower = _TYPE.format(name="follower", limit=limit, cruise=FREE_MPS2)
    rows = [
        f'<vehicle id="{vehicle}" type="{"follower" if rank else "leader"}" route="all" depart="0"'
        f' departPos="{_position_m(case, rank)}" departSpeed="{SPEED_MPS}"/>'
        for rank, vehicle in enumerate(_VEHICLES)
    ]
    route = '<route id="all" edges="road"/>'
    return "\n".join(["<routes>", leader, follower, route, *rows, "</routes>"])


def _position_m(case: Case, rank: int) -> float:
    return _FIRST_M - rank * (LENGTH_M + case.law.bumper_gap_m)


def _place(api: Any, step: Any, case: Case) -> None:
    """Wait until all vehicles are on the road, put them at their distances, and start the laws."""
    placed: set[str] = set()
    while len(placed) < SIZE:
        step()
        for vehicle in set(api.getIDList()) - placed:
            api.setSpeedMode(vehicle, 0)  # the law alone decides
            _set(api, vehicle, ccac=_ACC, ccfa="1:0")  # a fixed acceleration of 0
            placed.add(vehicle)
    for rank, vehicle in enumerate(_VEHICLES):
        api.moveTo(vehicle, "road_0", _position_m(case, rank))
        _set(api, vehicle, ccds=SPEED_MPS, ccfa="0:0")
        if rank > 0:
            own = dict(case.law.sumo)
            platoon = {"ccvp": rank, "ccps": SIZE, "ccsp": case.law.bumper_gap_m}
            _set(api, vehicle, ccac=case.law.controller, **platoon | own | {"ccds": 60})
            if case.limited == "commands":
                _set(api, vehicle, ccumin=-BRAKING_MPS2, ccumax=BRAKING_MPS2)


def _driven(api: Any, step: Any, case: Case) -> Motion:
    positions, speeds = [], []
    steps = round(DURATION_S[case.manoeuvre] / STEP_S)
    for number in range(steps + 1):
        positions.append([api.getLanePosition(vehicle) for vehicle in _VEHICLES])
        speeds.append([api.getSpeed(vehicle) for vehicle in _VEHICLES])
        if number == steps:
            break
        if number % BEACON_STEPS == 0:
            _inform(api, case.law)
        if case.manoeuvre == "sine":
            _set(api, _VEHICLES[0], ccds=wanted_mps(number))
        elif number == round(BRAKES_AT_S / STEP_S):
            _set(api, _VEHICLES[0], ccfa=f"1:{-BRAKING_MPS2}")
        step()
    position = np.array(positions)
    return Motion(position[:, :-1] - position[:, 1:] - LENGTH_M, np.array(speeds))


def _inform(api: Any, law: Law) -> None:
    """Give all vehicles the states of the others, as beacons do."""
    states = [_state(api, vehicle, law) for vehicle in _VEHICLES]
    for rank, vehicle in enumerate(_VEHICLES[1:], start=1):
        _set(api, vehicle, cclsa=_report(states[0]), ccpsa=_report(states[rank - 1]))
        for other, state in enumerate(states):
            if other != rank:
                speed, acceleration, command, x, y, at_s, *velocity = state
                now = [speed, acceleration, x, y, at_s, LENGTH_M, command, *velocity]
                _set(api, vehicle, ccvd=_packed(other, *now))


def _state(api: Any, vehicle: str, law: Law) -> list[float]:
    """Return speed, acceleration, command, position, time, velocity and angle of a vehicle."""
    state = [float(one) for one in api.getParameter(vehicle, "carFollowModel.ccsa").split(":")]
    if law.reports_mean:
        acceleration, command = state[1:3]
        state[1] = command + (acceleration - command) * (1.0 - math.exp(-PLAN)) / PLAN
    return state


def _report(state: Sequence[float]) -> str:
    speed, acceleration, command, x, y, at_s, *velocity = state
    return _packed(speed, acceleration, x, y, at_s, command, *velocity)


def _packed(*values: float) -> str:
    return ":".join(str(value) for value in values)


def _set(api: Any, vehicle: str, **parameters: object) -> None:
    for name, value in parameters.items():
        api.setParameter(vehicle, f"carFollowModel.{name}", str(value))


if __name__ == "__main__":
    main(*sys.argv[1:])
