"""Derives the input of linear theory from a run: each vehicle's law, gains and delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.laws import LoggedLaw
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.theory.chain import Member, open_road
from zenvoy.analysis.theory.laws import Coupling, total_delay_s
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Gains, Scenario, roster, setpoint_at

Rows = NDArray[np.int64]

_SELDOM: Final = 0.01  # share of the vehicles' time under another law that can be ignored
_STALE: Final = 0.5  # of a period; a larger mean age of the neighbours' data is a caveat


@dataclass(frozen=True, slots=True, kw_only=True)
class Theory:
    """The vehicles of a run in linear theory.

    `alike` is the law and gains of all vehicles, on a ring where they are the same. `caveats` say
    how the run differs from the theory.
    """

    members: tuple[Member, ...]
    alike: Member | None
    caveats: tuple[str, ...]


class NoTheoryError(Exception):
    """Linear theory does not apply to a run; the text says why."""


def require_theory(scenario: Scenario) -> None:
    """Raise NoTheoryError if linear theory does not cover the settings of the whole fleet."""
    if scenario.control.neighbour_state == "position":
        raise NoTheoryError("it covers control by radar readings, not by reported positions.")


def theory_of(run: Run, low_s: float, high_s: float) -> Theory:
    """Return the theory for the laws in force from low_s to high_s; raises NoTheoryError."""
    scenario = run.scenario
    require_theory(scenario)
    time_s = run.estimate.get("time_ns", np.zeros(0)) * 1e-9
    rows = np.flatnonzero((time_s >= low_s) & (time_s < high_s))
    if not rows.size:
        raise NoTheoryError("no decision was logged in that time.")
    modes, seldom = _prevailing(run.estimate["mode"][rows])
    members = [_member(run, v, int(mode), rows) for v, mode in enumerate(modes)]
    if min(member.gains.k_d for member in members) <= 0.0:
        raise NoTheoryError("k_d is 0, so nothing restores the gaps.")
    ring = scenario.road.type == "ring"
    alike = members[0] if ring and len(set(members)) == 1 else None
    return Theory(
        members=tuple(members if ring else open_road(members)),
        alike=alike,
        caveats=tuple(_caveats(run, rows, seldom, modes)),
    )


def _prevailing(mode: NDArray[np.uint32]) -> tuple[list[int], float]:
    """Return each vehicle's most frequent mode, and the share of time spent in other modes."""
    most = int(mode.max(initial=0)) + 1
    counts = np.stack([np.bincount(column, minlength=most) for column in mode.T])
    return counts.argmax(axis=1).tolist(), 1.0 - float(counts.max(axis=1).sum() / mode.size)


def _member(run: Run, vehicle: int, mode: int, rows: Rows) -> Member:
    scenario, law = run.scenario, _law(run, vehicle, mode)
    settings = roster(scenario)[vehicle]
    at_ns = int(run.estimate["time_ns"][rows[0]])
    setpoint = setpoint_at(settings.targets, at_ns)
    predicts = law is not None and law.predicts
    delay_s = total_delay_s(scenario.control, scenario.period_ms, predicts=predicts)
    if law is None:
        gains = Gains(k_d=setpoint.k_d, k_v=setpoint.k_v, k_c=setpoint.k_c)
        return Member(None, gains, delay_s, settings.lag_s)
    m = 0
    if law.counts_sides:  # the most frequent m; it is 0 at the end of a road, where FM acts
        m = int(np.bincount(run.estimate["neighbours"][rows, vehicle]).argmax())
        law = law if m else run.laws[pb.MODE_FM]
    given = [phase.parameters for phase in settings.phases if phase.from_ns <= at_ns][-1]
    linear = law.linear_at(scenario.control, given, setpoint, m)
    if linear is None:
        raise NoTheoryError(f"vehicle {vehicle + 1} ran {law.name}, which has no linear form.")
    coupling = Coupling(linear.ahead, linear.behind)
    gains = Gains(k_d=linear.k_d, k_v=linear.k_v, k_c=linear.k_c)
    return Member(coupling, gains, delay_s, settings.lag_s)


def _law(run: Run, vehicle: int, mode: int) -> LoggedLaw | None:
    """Return the law behind a mode; None for constant speed. Raises NoTheoryError."""
    if mode == pb.MODE_CONSTANT_SPEED:
        return None
    law = run.laws.get(mode)
    if law is None:
        raise NoTheoryError(f"vehicle {vehicle + 1} was in mode {mode}, which has no known law.")
    return law


def _caveats(run: Run, rows: Rows, seldom: float, modes: list[int]) -> list[str]:
    caveats = []
    if seldom > _SELDOM:
        caveats.append(
            f"Vehicles spent {100.0 * seldom:.0f} % of their time under a law other than their "
            "most frequent one; the theory assumes the most frequent one throughout."
        )
    start_ns, end_ns = (int(run.estimate["time_ns"][row]) for row in (rows[0], rows[-1]))
    targets = [settings.targets for settings in roster(run.scenario)]
    gains = [course for t in targets for course in (t.k_d, t.k_v, t.k_c)]
    if not all(course.is_constant(start_ns, end_ns) for course in gains):
        caveats.append(
            "The schedule changes gains during this time; the theory uses the initial ones."
        )
    laws = [law for mode in set(modes) if (law := run.laws.get(mode)) is not None]
    foresee = sorted(law.name for law in laws if law.predicts)
    if foresee and run.scenario.sensors.error > 0.0:
        caveats.append(
            f"For {', '.join(foresee)} the theory assumes an exact prediction, and ignores the "
            "dynamics of the filter."
        )
    age_ns = run.estimate["age_ns"][rows]
    known = age_ns[age_ns >= 0]
    two_sided = any(law.looks_behind and not law.predicts for law in laws)
    if two_sided and known.size and known.mean() > _STALE * run.scenario.period_ns:
        caveats.append(
            f"The data of the vehicle behind are {known.mean() * 1e-6:.0f} ms old on average when "
            "a cycle begins; the theory assumes that they are new."
        )
    return caveats
