"""A synthetic platoon, and tables of it in the forms in which others publish such recordings.

The cars are invented: each follows the one ahead by the linear law a = k (Δx - s) + l Δv, whose
swing grows from car to car as theory says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP_S: Final = 0.1
LENGTH_M: Final = 5.0
CARS: Final = ("LEAD_CAR", "CAR_B", "CAR_C", "CAR_D")
K, L, GAP_M = 0.1, 0.4, 20.0  # s⁻², s⁻¹, m from bumper to bumper


class Platoon(NamedTuple):
    """Time (T,), speed (T, n) and gaps from bumper to bumper (T, n), NaN for the leader."""

    time_s: Floats
    speed: Floats
    gap: Floats

    @property
    def position(self) -> Floats:
        """Positions of the fronts, m, of which the leader's begins at 100."""
        steps = STEP_S * 0.5 * (self.speed[1:, 0] + self.speed[:-1, 0])
        first = 100.0 + np.concatenate([[0.0], np.cumsum(steps)])
        behind = np.cumsum(np.nan_to_num(self.gap + LENGTH_M), axis=1)
        return np.asarray(first[:, None] - behind)


def platoon(seconds: float = 60.0, hz: float = 0.05, swing: float = 1.0) -> Platoon:
    """Return four cars behind a leader of 15 m/s whose speed swings, with 1/100 s steps inside."""
    fine = np.arange(0.0, seconds + 0.5 * STEP_S, 0.01)
    speed = np.zeros((len(fine), len(CARS)))
    gap = np.full((len(fine), len(CARS)), np.nan)
    speed[:, 0] = 15.0 + swing * np.sin(2.0 * np.pi * hz * fine)
    speed[0], gap[0, 1:] = speed[0, 0], GAP_M
    for k in range(len(fine) - 1):
        for car in range(1, len(CARS)):
            relative = speed[k, car - 1] - speed[k, car]
            a = K * (gap[k, car] - GAP_M) + L * relative
            speed[k + 1, car] = speed[k, car] + 0.01 * a
            gap[k + 1, car] = gap[k, car] + 0.01 * relative
    rows = slice(None, None, 10)
    return Platoon(fine[rows], speed[rows], gap[rows])


def openacc_text(
    found: Platoon,
    *,
    cars: Sequence[str] = CARS,
    about: Mapping[str, str] | None = None,
    begin_s: float = 780.0,
) -> str:
    """Return a file in the form of OpenACC: five lines on the drive, then the cars side by side."""
    lines = {"Date": "8,10,2019", "Vehicle_order": f"{','.join(cars)},",
             "Number_of_vehicles": str(len(cars)), "ACC": "1", "Distance_setting": "S"}  # fmt: skip
    lines |= about or {}
    count = len(cars)
    header = ["Time"]
    for car in range(1, count + 1):
        header += [f"Speed{car}", f"E{car}", f"N{car}"]
    header += [f"IVS{car}" for car in range(1, count)]
    rows = [header]
    for time_s, speed, gap in zip(*found, strict=True):
        row = [f"{begin_s + time_s:.1f}"]
        for v in speed:
            row += [f"{v:.5f}", "1.5", "2.5"]
        rows.append(row + [f"{g:.5f}" for g in gap[1:]])
    text = [f"{name},{value}" for name, value in lines.items()]
    return "\n".join([*text, *(",".join(row) for row in rows)]) + "\n"


def wide_text(found: Platoon) -> str:
    """Return a table with a column of speeds in km/h and of positions for each car."""
    names = [f"v_{car} [km/h]" for car in CARS] + [f"x_{car}" for car in CARS]
    rows = [";".join(["t_ms", *names])]
    for time_s, speed, x in zip(found.time_s, found.speed, found.position, strict=True):
        cells = [f"{1000 * time_s:.0f}", *(f"{3.6 * v:.5f}" for v in speed)]
        rows.append(";".join([*cells, *(f"{one:.5f}" for one in x)]))
    return "\n".join(rows) + "\n"


def long_text(found: Platoon, order: Sequence[int] = (2, 0, 3, 1)) -> str:
    """Return a table with a row for each time and car, the cars in some order, as from SUMO."""
    rows = ["time,id,x,v"]
    for time_s, speed, x in zip(found.time_s, found.speed, found.position, strict=True):
        rows += [f"{time_s:.1f},{CARS[car]},{x[car]:.5f},{speed[car]:.5f}" for car in order]
    return "\n".join(rows) + "\n"
