"""What linear theory takes from a run: who was under which law, with which gains and delay."""

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
from zenvoy.scenarios import Gains, roster, setpoint_at

Rows = NDArray[np.int64]

_SELDOM: Final = 0.01  # share of the vehicles' time under another law that does not matter
_STALE: Final = 0.5  # of a period: mean age of the neighbours' data from which it is said


@dataclass(frozen=True, slots=True, kw_only=True)
class Theory:
    """Vehicles as linear theory sees them. `alike`: the one law of all, on a ring.

    `caveats` say in what the run differs from the theory.
    """

    members: tuple[Member, ...]
    alike: Member | None
    caveats: tuple[str, ...]


class NoTheoryError(Exception):
    """Why linear theory has nothing to say of a run."""


def theory_of(run: Run, low_s: float, high_s: float) -> Theory:
    """Theory of the laws in force from low_s to high_s; raises NoTheoryError."""
    scenario = run.scenario
    if scenario.control.neighbour_state == "position":
        raise NoTheoryError("the theory is of radar readings, not of reported positions.")
    time_s = run.estimate.get("time_ns", np.zeros(0)) * 1e-9
    rows = np.flatnonzero((time_s >= low_s) & (time_s < high_s))
    if not rows.size:
        raise NoTheoryError("no decision was logged in that time.")
    modes, seldom = _prevailing(run.estimate["mode"][rows])
    members = [_member(run, v, int(mode), rows) for v, mode in enumerate(modes)]
    if min(member.gains.k_d for member in members) <= 0.0:
        raise NoTheoryError("k_d is 0: nothing draws the gaps to what they should be.")
    ring = scenario.road.type == "ring"
    alike = members[0] if ring and len(set(members)) == 1 else None
    return Theory(
        members=tuple(members if ring else open_road(members)),
        alike=alike,
        caveats=tuple(_caveats(run, rows, seldom, modes)),
    )


def _prevailing(mode: NDArray[np.uint32]) -> tuple[list[int], float]:
    """Most frequent mode of each vehicle, and the share of time in which it was another one."""
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
        return Member(None, gains, delay_s)
    m = 0
    if law.counts_sides:  # as many as it mostly found; none at the end of a road, where FM acts
        m = int(np.bincount(run.estimate["neighbours"][rows, vehicle]).argmax())
        law = law if m else run.laws[pb.MODE_FM]
    given = [phase.parameters for phase in settings.phases if phase.from_ns <= at_ns][-1]
    linear = law.linear_at(scenario.control, given, setpoint, m)
    if linear is None:
        raise NoTheoryError(
            f"vehicle {vehicle + 1} was under {law.name}, of which it knows nothing."
        )
    coupling = Coupling(linear.ahead, linear.behind)
    return Member(coupling, Gains(k_d=linear.k_d, k_v=linear.k_v, k_c=linear.k_c), delay_s)


def _law(run: Run, vehicle: int, mode: int) -> LoggedLaw | None:
    """The law behind a mode; None for one that keeps its speed. Raises NoTheoryError."""
    if mode == pb.MODE_CONSTANT_SPEED:
        return None
    law = run.laws.get(mode)
    if law is None:
        raise NoTheoryError(f"vehicle {vehicle + 1} was in mode {mode}, of which it knows nothing.")
    return law


def _caveats(run: Run, rows: Rows, seldom: float, modes: list[int]) -> list[str]:
    caveats = []
    if seldom > _SELDOM:
        caveats.append(
            f"In {100.0 * seldom:.0f} % of their time vehicles were under another law than most "
            "of the time; the theory takes the prevailing one of each."
        )
    start_ns, end_ns = (int(run.estimate["time_ns"][row]) for row in (rows[0], rows[-1]))
    told = [told.targets for told in roster(run.scenario)]
    if any(
        not course.is_constant(start_ns, end_ns) for t in told for course in (t.k_d, t.k_v, t.k_c)
    ):
        caveats.append(
            "The schedule changes gains in that time; the theory takes those at its beginning."
        )
    laws = [law for mode in set(modes) if (law := run.laws.get(mode)) is not None]
    foresee = sorted(law.name for law in laws if law.predicts)
    if foresee and run.scenario.sensors.error > 0.0:
        caveats.append(
            f"{', '.join(foresee)}: the theory is of a prediction that is right, without the "
            "filter's own dynamics."
        )
    age_ns = run.estimate["age_ns"][rows]
    known = age_ns[age_ns >= 0]
    two_sided = any(law.looks_behind and not law.predicts for law in laws)
    if two_sided and known.size and known.mean() > _STALE * run.scenario.period_ns:
        caveats.append(
            f"The data of the vehicle behind are {known.mean() * 1e-6:.0f} ms old on average when "
            "a cycle begins; the theory takes them to be new."
        )
    return caveats
