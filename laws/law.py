"""The record of a control law, which holds everything that the rest of Zenvoy needs to know."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from zenvoy.laws.relative import NAN, Motion, Number, Relative

UNKNOWN: Final = Relative(NAN, NAN)
SILENT: Final = Motion(NAN, NAN)


class Setpoint(NamedTuple):
    """The gains and targets that the scenario sets for a vehicle now.

    Gains k_d (s⁻²), k_v and k_c (s⁻¹), desired gap p_des from front to front (m), desired speed
    v_des (m/s). The schedule may change each of them.
    """

    k_d: Number
    k_v: Number
    k_c: Number
    p_des: Number
    v_des: Number


class Observation(NamedTuple):
    """The input of a law for one decision.

    speed: own speed, m/s. acceleration: the own acceleration, m/s², as a mean over the period
    before the start of the cycle. length_m: length of every vehicle, m. ahead, behind: states of
    the links to the vehicle ahead and to the one behind. behind_age_s: age at the start of the
    cycle of what is known of the link behind, s; NaN unless the law shares links. sides: for j =
    1..m, the states to the j-th vehicle ahead and to the j-th behind, each over the whole distance.
    predecessor, leader: what the vehicle ahead and the leader of the platoon report of themselves.
    state: what the law returned as its state at the decision before. period_s: the time from one
    decision to the next, s. uniform: `uniform(k)` is the k-th random number in [0, 1) of this
    vehicle and cycle; apart from these, it depends only on the seed.

    Only what the law declares in `needs` is filled in; everything else is NaN or empty.
    """

    speed: Number
    setpoint: Setpoint
    ahead: Relative = UNKNOWN
    behind: Relative = UNKNOWN
    sides: tuple[tuple[Relative, Relative], ...] = ()
    predecessor: Motion = SILENT
    leader: Motion = SILENT
    state: tuple[Number, ...] = ()
    period_s: float = NAN
    uniform: Callable[[int], Number] = lambda _: NAN
    acceleration: Number = NAN
    length_m: float = NAN
    behind_age_s: Number = NAN


class Output(NamedTuple):
    """The result of a law that returns more than an acceleration (m/s²).

    logged: a number for each of the law's columns. state: its state at the next decision.
    """

    acceleration: Number
    logged: tuple[Number, ...] = ()
    state: tuple[Number, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Needs:
    """What a law needs to decide. If it is missing or too old, the vehicle falls back to FM.

    behind: the link to the vehicle behind, which is known only from V2V. sides: the number of
    vehicles on each side, or the name of the parameter that holds it. predecessor, leader: the
    motion that these report. commands: their reports also contain their newest commands; or the
    name of the parameter that says whether they do.
    tolerates_silence: if a report is missing, its motion is NaN and the law goes on. If the law
    shares links, this also applies to the link behind, whatever its age.
    prediction: filters estimate links and own speed, and predict them to the instant at which the
    command takes effect. The link ahead is always available. shares_links: both vehicles of a link
    act on one estimate of it, which the one at its rear makes; this needs `prediction`.
    """

    behind: bool = False
    sides: int | str = 0
    predecessor: bool = False
    leader: bool = False
    prediction: bool = False
    commands: bool | str = False
    tolerates_silence: bool = False
    shares_links: bool = False

    def __post_init__(self) -> None:
        """Raise ValueError if one need lacks another one that it is about."""
        if self.shares_links and not self.prediction:
            raise ValueError("shares_links needs prediction")


class Linear(NamedTuple):
    """A law linearised at its equilibrium: Σ_j w_j (k_d Δp_j + k_v Δv_j) - k_c v over neighbours.

    ahead, behind: weights of the neighbours on each side, nearest first. Gains in s⁻², s⁻¹, s⁻¹.
    """

    ahead: tuple[float, ...]
    behind: tuple[float, ...]
    k_d: float
    k_v: float
    k_c: float


class Column(NamedTuple):
    """A value that a law logs: its name, and its unit ("" if it has none)."""

    name: str
    unit: str = ""


@dataclass(frozen=True, slots=True)
class NoParameters:
    """A law without parameters of its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """A control law, by which a vehicle decides.

    name: its name in scenarios, logs and reports. acceleration: the law itself, a function of an
    Observation and of its parameters that returns an acceleration in m/s², or an Output. It reads
    no clock and no global state. parameters: a frozen dataclass with defaults; its annotations
    define what `control.parameters` may hold. section: the section of `control` that holds them
    instead. mode: its number in a log, for the laws of the library; a run numbers others itself.
    colour: the colour of its curves, `#RRGGBB`. linear: returns the law linearised at its
    equilibrium, from its parameters, the setpoint and the number of vehicles found on each side;
    None if this is not known. keeps_gap: whether it uses the desired gap. version: the version of
    its package; "" for a file.
    """

    name: str
    acceleration: Callable[[Observation, Any], Any]
    parameters: type = NoParameters
    section: str | None = None
    needs: Needs = Needs()
    keeps_gap: bool = True
    columns: tuple[Column, ...] = ()
    state: tuple[float, ...] = ()
    mode: int | None = None
    colour: str | None = None
    linear: Callable[[Any, Setpoint, int], Linear] | None = None
    version: str = ""

    def sides(self, parameters: Any) -> int:
        """Return how many vehicles on each side the law uses."""
        sides = self.needs.sides
        return int(getattr(parameters, sides)) if isinstance(sides, str) else sides

    def hears_commands(self, parameters: Any) -> bool:
        """Return whether the law uses the newest commands of others."""
        commands = self.needs.commands
        return bool(getattr(parameters, commands)) if isinstance(commands, str) else commands

    def two_sided(self) -> bool:
        """Return whether the law looks behind."""
        return self.needs.behind or self.needs.sides != 0

    def smallest_ring(self, parameters: Any) -> int:
        """Return how many vehicles a ring needs, so that none is ahead and behind at once."""
        return 2 * max(self.sides(parameters), int(self.needs.behind)) + 1
