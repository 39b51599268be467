"""A case is a signal that hits a process of a run at a moment. All kinds come in turn."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Final

CYCLES: Final = {"each": 400, "shared": 800, "realtime": 100}
STALL_LIMIT_S: Final = 5.0  # if a process is stopped
PATIENT_S: Final = 60.0  # stall limit of other runs: on a busy machine their start may take long
PAUSE_S: Final = 3.0  # how long a process is stopped before it goes on
SIZE: Final = 4

VICTIMS: Final = ("vehicle", "channel", "world", "command")
BLOWS: Final = ("KILL", "TERM", "INT", "HUP", "STOP 3 s", "STOP")
MODES: Final = tuple(CYCLES)
MOMENTS: Final = ("start", "middle", "last")

_NAMES: Final = tuple(f"vehicle-{vehicle:02d}" for vehicle in range(1, SIZE + 1))


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A victim, a signal, a kind of run and a moment. `at` in [0, 1) is the place in the moment."""

    victim: str
    blow: str
    mode: str
    moment: str
    at: float = 0.5

    def __str__(self) -> str:
        return f"{self.victim}, {self.blow}, {self.mode}, {self.moment} {self.at:.3f}"

    @property
    def process(self) -> str:
        """Return the name of the process that is hit."""
        if self.victim != "vehicle":
            return self.victim
        return "vehicles-03-04" if self.mode == "shared" else "vehicle-03"

    @property
    def others(self) -> set[str]:
        """Return the names of all processes but the command."""
        shared = self.mode == "shared"
        vehicles = {"vehicles-01-02", "vehicles-03-04"} if shared else set(_NAMES)
        return {"world", "channel", *vehicles}

    @property
    def stall_limit_s(self) -> float:
        """Return the stall limit of the run."""
        return STALL_LIMIT_S if self.blow.startswith("STOP") else PATIENT_S


_SCENARIO: Final = """
duration_s: {duration_s}
stall_limit_s: {limit_s}
clock: {clock}
fleet: {{size: {size}}}
control: {{v2v_wait_ms: 25, system_delay_ms: 50}}
channel: {{loss: {{p: 0.1}}}}
"""


def scenario_of(mode: str, limit_s: float, times: int = 1) -> str:
    """Return the scenario of a mode, as YAML; `times` as long as usual."""
    clock = "realtime" if mode == "realtime" else "lock-step"
    duration_s = times * CYCLES[mode] / 10
    return _SCENARIO.format(duration_s=duration_s, limit_s=limit_s, clock=clock, size=SIZE)


def all_kinds() -> list[Case]:
    """Return one case of every kind."""
    return [
        Case(victim=victim, blow=blow, mode=mode, moment=moment)
        for victim in VICTIMS
        for blow in BLOWS
        for mode in MODES
        for moment in MOMENTS
    ]


def random_cases(count: int, seed: int) -> list[Case]:
    """Return `count` cases at random moments: all kinds in turn, in a random order."""
    rng, kinds = random.Random(seed), all_kinds()
    found: list[Case] = []
    while len(found) < count:
        rng.shuffle(kinds)
        for kind in kinds:
            at = rng.random()
            found.append(
                Case(victim=kind.victim, blow=kind.blow, mode=kind.mode, moment=kind.moment, at=at)
            )
    return found[:count]
