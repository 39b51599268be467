"""Tables of string stability: figures and modes, measured and by theory."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from statistics import mean

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.chapters.mode_sheets import slowest
from zenvoy.analysis.chapters.stability_pictures import EXCITED, followers
from zenvoy.analysis.chapters.stability_vehicles import gains_beside, pair
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.stability import norms, response, wave_speed
from zenvoy.analysis.measures.stretches import Stretch
from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.analysis.theory.chain import Member
from zenvoy.analysis.theory.disturbed import Disturbed, fluctuation
from zenvoy.analysis.theory.laws import FM, group_delay_s, is_string_stable, peak_gain
from zenvoy.analysis.theory.ring import long_wave_speed, metres_per_second
from zenvoy.analysis.theory.ring_modes import Modes

Floats = NDArray[np.float64]
Row = tuple[Cell, ...]


def figure_sheet(run: Run, case: Disturbed, modes: Modes) -> Sheet:
    """Return the figures that are single numbers, measured and by theory."""
    disturbance = case.disturbance
    theory = " Theory is linear, for the actual motion of the disturbed vehicle."
    theory = "" if case.predicted is None else theory
    return Sheet(
        name="stability-figures",
        title="String stability in figures",
        columns=("figure", "unit", "measured", "theory"),
        rows=(*_gains(case), *_one_pair(run, case), *_waves(run, case), *slowest(modes)),
        note=f"The figures cover {case.time_s[0]:g} to {case.time_s[-1]:g} s, after vehicle "
        f"{disturbance.vehicle} was disturbed ({disturbance.kind}: {disturbance.text}).{theory}",
    )


def _gains(case: Disturbed) -> list[Row]:
    rows: list[Row] = []
    last = len(case.backwards) - 1
    for field, name in (("l2", "L2"), ("linf", "L∞")):
        both = [getattr(gains, field) for gains in gains_beside(case)]
        steps = [_largest_step(case, values) for values in both]
        ends = [float(values[case.backwards[-1]]) for values in both]
        rows += [
            (f"largest {name} gain from one vehicle to the next", "", *pair(steps)),
            (f"{name} gain to the vehicle {last} places behind", "", *pair(ends)),
        ]
    return rows


def _largest_step(case: Disturbed, gain: Floats) -> float | None:
    above_noise = case.above_noise
    steps = [
        float(gain[vehicle] / gain[before])
        for order in (case.backwards, case.forwards)
        for before, vehicle in pairwise(order)
        if above_noise[before]
    ]
    return max(steps, default=None)


def _one_pair(run: Run, case: Disturbed) -> list[Row]:
    """Return the figures of one vehicle behind another, in a string under FM."""
    chain = _following(case)
    if chain is None:
        return []
    _, gains, delay_s, lag_s = chain
    peak = peak_gain(gains, delay_s, lag_s)
    gain, omega = _measured_peak(run, case)
    packet_s = group_delay_s(peak.omega, gains, delay_s, lag_s)
    return [
        (
            "string-stable without delay and lag: κ² + 2 k_v κ ≥ 2 k_d",
            "",
            None,
            "yes" if is_string_stable(gains) else "no",
        ),
        ("delay (V2V wait, system, half a period)", "s", None, delay_s),
        *([("lag of the actuator", "s", None, lag_s)] if lag_s else []),
        ("peak gain to the next vehicle", "", gain, peak.gain),
        ("frequency of that peak", "rad/s", omega, peak.omega),
        ("group delay at that peak", "s", None, packet_s),
    ]


def _following(case: Disturbed) -> Member | None:
    """Return the law of the vehicles behind the disturbed one if it is the same FM for all."""
    if case.theory is None or len(case.backwards) < 2:
        return None
    laws = {case.theory.members[i] for i in case.backwards[1:]}
    law = laws.pop()
    return law if not laws and law.coupling == FM else None


def _measured_peak(run: Run, case: Disturbed) -> tuple[float | None, float | None]:
    """Return the peak gain from one vehicle to the next, and its frequency.

    It is the k-th root of the gain to the farthest vehicle shown, which is k places behind.
    """
    shown = followers(run, case)
    if not shown:
        return None, None
    k = shown[-1]
    acceleration = run.truth["acceleration"][case.rows]
    head, tail = acceleration[:, case.source], acceleration[:, case.backwards[k]]
    found = response(head, tail, case.period_s, EXCITED)
    gain = np.abs(found.ratio) ** (1.0 / k)
    best = int(np.argmax(gain))
    around = slice(best - 1, best + 2)
    if not 0 < best < len(gain) - 1:
        return float(gain[best]), float(found.omega[best])
    # A parabola finds the peak between the frequencies that the record resolves.
    curve = np.polyfit(found.omega[around], gain[around], 2)
    omega = -curve[1] / (2.0 * curve[0])
    return float(np.polyval(curve, omega)), float(omega)


def _waves(run: Run, case: Disturbed) -> list[Row]:
    if not case.has_dip:
        return []
    rows: list[Row] = []
    gap_m = mean(run.scenario.fleet.gaps_at_start_m)
    speed_mps = float(run.truth["speed"][case.rows].mean())
    for order, direction, sign in (
        (case.backwards, "backwards", 1.0),
        (case.forwards, "forwards", -1.0),
    ):
        measured = wave_speed(case.dips(case.deviation, order))
        theory = None if case.predicted is None else wave_speed(case.dips(case.predicted, order))
        if measured is None and theory is None:
            continue
        over = [
            None if speed is None else metres_per_second(sign * speed, gap_m, speed_mps)
            for speed in (measured, theory)
        ]
        what = f"dip {direction}, speed"
        rows.append((f"{what} from vehicle to vehicle", "vehicles/s", measured, theory))
        rows += _over_the_road(what, over)
    alike = case.theory.alike if case.theory else None
    if alike is not None and alike.coupling is not None:
        long = long_wave_speed(alike.coupling, alike.gains)
        rows.append(
            ("speed of long waves", "vehicles/s", None, long if math.isfinite(long) else None)
        )
    return rows


def _over_the_road(what: str, both: Sequence[float | None]) -> list[Row]:
    """Return speeds over the road, m/s, without a sign; the name gives the direction."""
    rows: list[Row] = []
    for direction, sign in (("against the traffic", -1.0), ("with the traffic", 1.0)):
        speeds = [None if v is None or sign * v < 0.0 else abs(v) for v in both]
        if any(v is not None for v in speeds):
            rows.append((f"{what} over the road, {direction}", "m/s", *speeds))
    return rows


def stretch_sheet(run: Run, case: Disturbed) -> Sheet:
    """Return a row per linear stretch, with gains of speed fluctuations around each mean."""
    return Sheet(
        name="stability-stretches",
        title="Linear stretches",
        columns=(
            "from, s",
            "to, s",
            "disturbed vehicle's fluctuation, m/s",
            f"L2 gain to vehicle {case.backwards[-1] + 1}",
            f"L∞ gain to vehicle {case.backwards[-1] + 1}",
            "largest L2 gain to the next",
        ),
        rows=tuple(_stretch_row(run, case, stretch) for stretch in case.stretches),
        note="Deviations are from each vehicle's mean speed over the stretch. The fluctuation is "
        "their standard deviation.",
    )


def _stretch_row(run: Run, case: Disturbed, stretch: Stretch) -> Row:
    found = norms(fluctuation(run, stretch), case.period_s)
    chain = [
        (before, after) for before, after in pairwise(case.backwards) if found.l2[before] > 0.0
    ]
    steps = [float(found.l2[after] / found.l2[before]) for before, after in chain]
    last, source = case.backwards[-1], case.source
    moved = found.l2[source] > 0.0
    return (
        float(run.time_s[stretch.low]),
        float(run.time_s[stretch.high - 1]),
        float(found.l2[source] / math.sqrt(stretch.rows * case.period_s)),
        float(found.l2[last] / found.l2[source]) if moved else None,
        float(found.linf[last] / found.linf[source]) if moved else None,
        max(steps, default=None),
    )
