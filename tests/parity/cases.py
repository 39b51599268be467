"""What both simulators run: eight cars under a law, whose leader oscillates or brakes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Manoeuvre = Literal["sine", "braking"]
Limited = Literal["nothing", "commands", "engines"]

SIZE: Final = 8
LENGTH_M: Final = 4.0
SPEED_MPS: Final = 100.0 / 3.6
LAG_S: Final = 0.5
PLAN: Final = 0.25  # a vehicle plans its acceleration in steps of a quarter of the lag
STEP_S: Final = 0.01
BEACON_STEPS: Final = 10  # a beacon every 100 ms
AMPLITUDE_MPS: Final = 10.0 / 3.6
FREQUENCY_HZ: Final = 0.2
WINDOW_S: Final = (25.0, 55.0)  # six periods
BRAKES_AT_S: Final = 5.0
BRAKING_MPS2: Final = 8.0
COMFORTABLE_MPS2: Final = 1.5  # the most that SUMO's cruise control commands
FREE_MPS2: Final = 30.0  # more than any law commands here
DURATION_S: Final[dict[Manoeuvre, float]] = {"sine": 55.0, "braking": 30.0}


@dataclass(frozen=True, slots=True)
class Law:
    """A law, its number in SUMO's model CC, its gap at 100 km/h, and its settings on both sides.

    zenvoy, sumo: its settings there, by key; Zenvoy's are beyond those of platoon.yaml.
    reports_mean: whether vehicles in SUMO report the mean acceleration that they expect, as
    Zenvoy's do.
    """

    name: str
    controller: int
    bumper_gap_m: float
    zenvoy: tuple[str, ...]
    sumo: tuple[tuple[str, str], ...] = ()
    reports_mean: bool = False


_PLEXE: Final = ("control.model=CACC", "control.platoon.reported_speed=true")
LAWS: Final = (
    Law("ACC", 1, 2.0 + 1.2 * SPEED_MPS, ("control.model=ACC",), (("ccaht", "1.2"),)),
    Law("CACC", 2, 5.0, (*_PLEXE, "control.platoon.commanded=true")),
    Law("CACC, acted", 2, 5.0, _PLEXE, (("ccca", "0"),)),
    Law("CACC, expected", 2, 5.0, _PLEXE, (("ccca", "0"),), reports_mean=True),
    Law("Ploeg", 4, 2.0 + 0.5 * SPEED_MPS, ("control.model=Ploeg",)),
    Law("Consensus", 5, 15.0 + 0.8 * SPEED_MPS, ("control.model=Consensus",)),
    Law("GSBL", 6, 5.0, ("control.model=GSBL",)),
)
# Without commands fed forward, 5 m are not enough to brake behind this leader.
THAT_COLLIDE: Final = tuple(law for law in LAWS if law.name in {"CACC, acted", "CACC, expected"})


@dataclass(frozen=True, slots=True)
class Case:
    """A run of a law, and what is limited to BRAKING_MPS2 (in Zenvoy this is always commands)."""

    law: Law
    manoeuvre: Manoeuvre
    limited: Limited = "nothing"


class Motion(NamedTuple):
    """Gaps from bumper to bumper of vehicles 2..8 (m), and speeds of vehicles 1..8 (m/s)."""

    gap: Floats
    speed: Floats


def wanted_mps(step: int) -> float:
    """Return the speed that the leader aims at in a step of the sine, m/s."""
    return SPEED_MPS + AMPLITUDE_MPS * math.sin(math.tau * FREQUENCY_HZ * step * STEP_S)


def swing(values: Floats) -> Floats:
    """Return half the range of each column within the window."""
    start, end = (round(at_s / STEP_S) for at_s in WINDOW_S)
    within = values[start:end]
    swung: Floats = (within.max(axis=0) - within.min(axis=0)) / 2.0
    return swung
