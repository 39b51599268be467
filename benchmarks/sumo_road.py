"""SUMO on a straight road: vehicles under its own car-following model, without V2V.

It runs in this process (libsumo), in a process of its own so that other rows do not suffer.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

import libsumo as sumo

STEP_S = 0.1
GAP_M = 37.5
SPEED_MPS = 30.0
ROAD_M = 40_000.0

NET = """\
<net version="1.20">
    <location netOffset="0,0" convBoundary="0,0,{0},0" origBoundary="0,0,{0},0" projParameter="!"/>
    <edge id="road" from="a" to="b" priority="1">
        <lane id="road_0" index="0" speed="40" length="{0}" shape="0,-1.6 {0},-1.6"/>
    </edge>
    <junction id="a" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,0 0,-3.2"/>
    <junction id="b" type="dead_end" x="{0}" y="0" incLanes="road_0" intLanes="" shape="{0},0"/>
</net>
"""


def routes(vehicles: int) -> str:
    """Return a file of routes: a row of vehicles, the first one farthest along the road."""
    lines = [
        f'<vehicle id="{number}" type="car" route="all" depart="0"'
        f' departPos="{10.0 + (vehicles - number) * GAP_M}" departSpeed="{SPEED_MPS}"/>'
        for number in range(1, vehicles + 1)
    ]
    head = ['<vType id="car" length="5" maxSpeed="30"/>', '<route id="all" edges="road"/>']
    return "\n".join(["<routes>", *head, *lines, "</routes>"])


def rate(vehicles: int, duration_s: float, *, commands: bool) -> float:
    """Return vehicle-seconds per second of CPU; commands: each speed is read and set each step."""
    with tempfile.TemporaryDirectory(prefix="zenvoy-sumo-") as folder:
        net, route = Path(folder, "net.xml"), Path(folder, "routes.xml")
        net.write_text(NET.format(ROAD_M))
        route.write_text(routes(vehicles))
        files = ["-n", str(net), "-r", str(route), "--step-length", str(STEP_S)]
        sumo.start(["sumo", *files, "--no-step-log", "--no-warnings"])
        try:
            names: Any = ()
            while len(names) < vehicles:  # it puts one vehicle on the road per step
                sumo.simulationStep()
                names = sumo.vehicle.getIDList()
            steps = round(duration_s / STEP_S)
            start_s = process_time()
            for _ in range(steps):
                if commands:
                    for name in names:
                        sumo.vehicle.setSpeed(name, sumo.vehicle.getSpeed(name))
                sumo.simulationStep()
            return vehicles * duration_s / (process_time() - start_s)
        finally:
            sumo.close()


if __name__ == "__main__":
    print(rate(int(sys.argv[1]), float(sys.argv[2]), commands=sys.argv[3] == "commands"))
