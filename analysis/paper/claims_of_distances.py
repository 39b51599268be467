"""The claims of Section IV-C on the smallest distances."""

from __future__ import annotations

import math
from typing import Final

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.measures.statistics import Mean, mean_of
from zenvoy.analysis.paper.claim import BILATERAL, END_S, LARGE_ERROR, SMALL_ERROR, Answer, claim
from zenvoy.analysis.paper.evidence import (
    PAIRS,
    Evidence,
    Pair,
    case,
    lowest,
    recovery_s,
    settled,
)


def _dip(evidence: Evidence, model: str) -> Mean:
    return evidence.over(
        case(model, LARGE_ERROR), lambda run: lowest(run, "min_distance", 10.0, 45.0)
    )


@claim(
    where="Fig. MinDistance, 10 %, 0.1 s",
    says="Under PBCM the braking takes MinDistance from 35 m to 33 m",
    needs_s=45,
)
def dip_of_pbcm(evidence: Evidence) -> Answer:
    dip = _dip(evidence, "PBCM")
    before = evidence.over(
        case("PBCM", LARGE_ERROR), lambda run: settled(run, "min_distance", 5.0, 10.0)
    )
    near = abs(dip.mean - 33.0) <= 1.0 and abs(before.mean - 35.0) <= 1.0
    return Answer(
        ours=f"from {before.text()} to {dip.text(2, 'm')}",
        verdict="confirmed" if near else "not confirmed",
        why="Before the braking, FM on the readings determines MinDistance, and then the braking"
        " itself.",
    )


@claim(
    where="Fig. MinDistance, 10 %, 0.1 s",
    says="The braking takes MinDistance to 26 m under MBCM and to 24 m under BCM: PBCM resists it"
    " best",
    needs_s=45,
)
def dips_of_the_others(evidence: Evidence) -> Answer:
    dips = {model: _dip(evidence, model) for model in BILATERAL}
    order = dips["PBCM"].above(dips["MBCM"]) and dips["PBCM"].above(dips["BCM"])
    gain = dips["PBCM"].mean - dips["BCM"].mean
    return Answer(
        ours=", ".join(f"{model} {dip.text()}" for model, dip in dips.items()) + " m",
        verdict="weaker" if order else "not confirmed",
        why=f"PBCM's dip is {gain:.2f} m shallower than BCM's; in the paper the difference is 9 m."
        " In two seconds of braking at 3 m/s² the gap behind a vehicle shrinks by up to 6 m. In"
        " that time controllers can do little, with or without estimates.",
    )


@claim(
    where="Fig. MinDistance, 10 %, 0.1 s",
    says="MinDistance settles at about 36 m under PBCM, 33 m under MBCM, 31 m under BCM",
    needs_s=500,
)
def settles(evidence: Evidence) -> Answer:
    ends = {
        model: evidence.over(
            case(model, LARGE_ERROR), lambda run: settled(run, "min_distance", *END_S)
        )
        for model in BILATERAL
    }
    order = ends["PBCM"].above(ends["MBCM"]) and ends["PBCM"].above(ends["BCM"])
    figures = ", ".join(f"{model} {end.text()}" for model, end in ends.items())
    near = abs(ends["PBCM"].mean - 36.0) < 1.0
    return Answer(
        ours=f"{figures} m (400 to 500 s)",
        verdict=("weaker" if ends["BCM"].mean > 32.0 else "confirmed")
        if order and near
        else "not confirmed",
        why="PBCM is best, and its value agrees with the paper. BCM and MBCM suffer less from the"
        " same errors than in the paper. MBCM adds up the errors of several radars, so looking"
        " farther does not help here.",
    )


@claim(
    where="Fig. MinDistance",
    says="From 3 % to 10 % error MinDistance hardly changes under PBCM, and falls under BCM and"
    " MBCM",
    needs_s=500,
)
def insensitive_to_error(evidence: Evidence) -> Answer:
    def change(model: str) -> Mean:
        small, large = (
            [settled(run, "min_distance", *END_S) for run in evidence[case(model, pair)]]
            for pair in (SMALL_ERROR, LARGE_ERROR)
        )
        return mean_of([b - a for a, b in zip(small, large, strict=True)])

    changes = {model: change(model) for model in BILATERAL}
    figures = ", ".join(f"{model} {value.text()}" for model, value in changes.items())
    least = all(changes["PBCM"].above(changes[model]) for model in ("BCM", "MBCM"))
    return Answer(
        ours=f"change of MinDistance: {figures} m",
        verdict="confirmed" if least else "not confirmed",
        why="The runs have the same seeds, so they can be compared one by one. PBCM acts on"
        " estimates, whose error is a fraction of that of the readings.",
    )


@claim(
    where="Fig. MinDistance",
    says="From 0.1 s to 0.2 s delay MinDistance falls sharply under BCM and MBCM, and only from"
    " 36 m to 35 m under PBCM",
    needs_s=500,
)
def delay(evidence: Evidence) -> Answer:
    def ends(model: str, delay_s: float) -> Mean:
        label = case(model, Pair(0.10, delay_s))
        return evidence.over(label, lambda run: settled(run, "min_distance", *END_S))

    texts, falls = [], {}
    for model in BILATERAL:
        short, long = ends(model, 0.1), ends(model, 0.2)
        texts.append(f"{model} {short.text()} to {long.text()}")
        falls[model] = short.mean - long.mean
    fall = min(falls["BCM"], falls["MBCM"])
    steeper = fall > max(0.0, falls["PBCM"])
    return Answer(
        ours=f"at 10 %: {', '.join(texts)} m",
        verdict="not confirmed"
        if fall < 0.5 or not steeper
        else ("weaker" if fall < 3.0 else "confirmed"),
        why="With these gains, an additional 0.1 s is small compared with the time constants of the"
        " laws (the slowest ring mode takes tens of seconds to decay), and all bilateral models"
        " stay stable.",
    )


def _recoveries(evidence: Evidence, model: str) -> list[float]:
    return [recovery_s(run) for pair in PAIRS for run in evidence[case(model, pair)]]


def _times(values: list[float]) -> str:
    back = [value for value in values if not math.isnan(value)]
    if not back:
        return "never"
    late = f"; {len(values) - len(back)} of {len(values)} runs never" * (len(back) < len(values))
    return f"{mean_of(back).text(0)} s (longest {max(back):.0f} s{late})"


@claim(
    where="Fig. MinDistance",
    says="Under PBCM MinDistance is back where it was within about 50 s",
    needs_s=500,
)
def recovery_of_pbcm(evidence: Evidence) -> Answer:
    times = _recoveries(evidence, "PBCM")
    within = sum(time <= 50.0 for time in times)
    return Answer(
        ours=f"time until its mean over 5 s stays within 0.5 m of its earlier value:"
        f" {_times(times)}; {within} of {len(times)} runs within 50 s",
        verdict="confirmed" if within == len(times) else "weaker",
        why="This covers all four pairs of error and delay. With 3 % it takes longer than with 10"
        " %, because the earlier value is higher: under FM, an error of 10 % lowers MinDistance.",
    )


@claim(
    where="Fig. MinDistance",
    says="BCM needs about 500 s to settle; MBCM settles fast, but lower",
    needs_s=500,
)
def recovery_of_the_others(evidence: Evidence) -> Answer:
    bcm, mbcm = (_recoveries(evidence, model) for model in ("BCM", "MBCM"))
    slow, late = (
        sum(math.isnan(time) or time > limit for time in of)
        for of, limit in ((bcm, 250.0), (mbcm, 60.0))
    )
    return Answer(
        ours=f"BCM {_times(bcm)}; MBCM {_times(mbcm)}",
        verdict="confirmed" if slow > len(bcm) / 2 else "not confirmed",
        why="With the gains used here, the slowest mode on this ring decays with a time constant of"
        " 32 s under BCM and 15 s under MBCM. The braking does not cause the long times: sensor"
        f" errors keep the distances moving, and {late} of {len(mbcm)} runs of MBCM leave the band"
        " of 0.5 m again later.",
    )


@claim(
    where="Fig. MinDistance",
    says="MBCM lowers MinDistance by 60 to 75 % of the initial state; elsewhere it settles at 33 m",
    needs_s=500,
)
def mbcm_against_itself(evidence: Evidence) -> Answer:
    label = case("MBCM", LARGE_ERROR)
    before = evidence.over(label, lambda run: settled(run, "min_distance", 5.0, 10.0))
    end = evidence.over(label, lambda run: settled(run, "min_distance", *END_S))
    return Answer(
        ours=f"from {before.text()} before the braking to {end.text(2, 'm')} from 400 s on",
        verdict="contradicts itself" if not 0.60 <= 1.0 - 33.0 / 35.0 <= 0.75 else "confirmed",
        why="60 to 75 % less than 35 m is 9 to 14 m, not 33 m (6 % less). If the sentence means"
        " that 60 to 75 % of the initial distance remain (21 to 26 m), it describes the dip to 26"
        " m.",
    )


@claim(
    where="Fig. error bars of MinDistance",
    says="PBCM has the smallest error bars, with large and with small error and delay",
    needs_s=500,
)
def error_bars(evidence: Evidence) -> Answer:
    def deviation(model: str, pair: Pair) -> Mean:
        def of(run: Digest) -> float:
            return float(run.min_distance[run.time_s >= 100.0].std())

        return evidence.over(case(model, pair), of)

    texts, best = [], True
    for pair in (PAIRS[3], PAIRS[0]):
        bars = {model: deviation(model, pair) for model in BILATERAL}
        best &= all(bars[model].above(bars["PBCM"]) for model in ("BCM", "MBCM"))
        figures = ", ".join(f"{model} {bar.text(3)}" for model, bar in bars.items())
        texts.append(f"{pair.title}: {figures} m")
    return Answer(
        ours="; ".join(texts) + " (standard deviation over time, from 100 s on)",
        verdict="confirmed" if best else "not confirmed",
        why="The paper's error bars are the RMSE of the data; ours are their standard deviation.",
    )


CLAIMS: Final = (
    dip_of_pbcm,
    dips_of_the_others,
    settles,
    insensitive_to_error,
    delay,
    recovery_of_pbcm,
    recovery_of_the_others,
    mbcm_against_itself,
    error_bars,
)
