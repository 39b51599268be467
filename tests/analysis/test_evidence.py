"""Evidence has means over seeds, figures of digests, and verdicts on claims."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import t as student

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.measures.statistics import mean_and_half, mean_of
from zenvoy.analysis.paper import gains
from zenvoy.analysis.paper.claim import LARGE_ERROR
from zenvoy.analysis.paper.claims import CLAIMS, answers
from zenvoy.analysis.paper.evidence import (
    MODELS,
    PAIRS,
    Evidence,
    at,
    case,
    lowest,
    recovery_s,
    settled,
)
from zenvoy.analysis.paper.gains import GAINS
from zenvoy.analysis.paper.reproduction import claims_page

VALUES = st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=40)


@given(VALUES)
def test_intervals_are_those_of_students_t(values: list[float]) -> None:
    found, error = mean_of(values), float(np.std(values, ddof=1)) / math.sqrt(len(values))
    assert found.mean == pytest.approx(float(np.mean(values)), abs=1e-9)
    if error > 1e-9:
        low, high = student.interval(0.95, len(values) - 1, loc=np.mean(values), scale=error)
        assert (found.low, found.high) == pytest.approx((low, high), rel=1e-9, abs=1e-9)


def test_nineteen_of_twenty_intervals_contain_the_mean() -> None:
    draws = np.random.default_rng(1).normal(5.0, 2.0, (10, 4_000))
    mean, half = mean_and_half(draws)
    held = np.count_nonzero(np.abs(mean - 5.0) <= half)
    assert 3_735 < held < 3_865  # 3800 ± 4.7 standard deviations


def test_one_value_has_no_interval() -> None:
    one = mean_of([3.25])
    assert (one.mean, one.text(2, "m")) == (3.25, "3.25 m")
    assert math.isnan(one.low)
    assert not one.above(mean_of([0.0]))
    assert mean_of([3.0, 3.5]).text(1) == "3.2 ± 3.2"


def made(seed: int = 1, end_s: float = 500.0, **columns: Any) -> Digest:
    """Return the digest of an uneventful run, with the given columns replaced."""
    time_s = np.arange(0.0, end_s + 0.05, 0.1)
    steady = {
        "min_distance": 36.0,
        "max_distance": 39.0,
        "spread": 0.2,
        "mean_speed": 30.0,
    } | columns
    fit = {"rmse": 1.0, "r2": 0.5, "r2_correlation": 0.5}
    fits = {f"{what}_speed": fit for what in ("measured", "estimated")}
    wave = 30.0 + np.sin(time_s[:-1])
    return Digest(
        time_s=time_s,
        snapshots=np.full((4, 40), 30.0),
        speed=np.full((501, 40), 30.0, dtype=np.float32),
        link=np.array([wave, wave + 1.0, wave, wave, wave, wave], dtype=np.float32),
        facts={
            "seed": seed,
            "vehicle": 5,
            "cycles": len(time_s) - 1,
            "fingerprint": "f",
            "collisions": 0,
            "standing": {"100": 0, "300": 0},
            "fit": {"whole": fits, "disturbed": fits},
        },
        **{name: np.broadcast_to(values, time_s.shape) for name, values in steady.items()},
    )


def evidence(
    of_case: Mapping[str, dict[str, Any]] = MappingProxyType({}), end_s: float = 500.0
) -> Evidence:
    """Return three slightly different seeds. `of_case` has columns by the number of the case."""
    runs: dict[str, tuple[Digest, ...]] = {}
    for label in [case(model, pair) for model in MODELS for pair in PAIRS]:
        columns = of_case.get(label, {})
        noisy = [
            {name: np.asarray(values) + 0.001 * seed for name, values in columns.items()}
            for seed in range(3)
        ]
        runs[label] = tuple(made(seed, end_s, **noisy[seed]) for seed in range(3))
    runs["sign/BCM"] = tuple(made(seed, end_s, mean_speed=80.0) for seed in range(3))
    return Evidence(runs=runs)


def verdict(found: Evidence, says: str) -> str:
    ((_, answer),) = [pair for pair in answers(found) if says in pair[0].says]
    return answer.verdict


def test_cases_are_numbered_as_in_the_paper() -> None:
    assert [case(model, pair) for model in MODELS for pair in PAIRS] == [
        f"{number:02}" for number in range(1, 17)
    ]
    assert [case(model, LARGE_ERROR) for model in MODELS] == ["03", "07", "11", "15"]


def test_figures_of_a_digest() -> None:
    time_s = np.arange(0.0, 20.05, 0.1)
    run = made(end_s=20.0, min_distance=time_s)
    assert settled(run, "min_distance", 5.0, 10.0) == pytest.approx(7.5)
    assert lowest(run, "min_distance", 5.0, 10.0) == pytest.approx(5.0)
    assert at(run, "min_distance", 7.3) == pytest.approx(7.3)
    for beyond in (
        settled(run, "min_distance", 30, 40),
        lowest(run, "min_distance", 30, 40),
        at(run, "min_distance", 30),
    ):
        assert math.isnan(beyond)


@pytest.mark.parametrize(
    ("dip", "back_s", "again", "recovered_s"),
    [
        (0.0, 20.0, False, 0.0),  # it never left
        (5.0, 40.0, False, 34.5),  # 90 % of 5 s are back 4.5 s after the step at 40 s
        (5.0, 40.0, True, 304.5),  # it leaves once more, from 300 s to 310 s
        (5.0, 600.0, False, math.nan),
    ],
)
def test_recovery_time_of_a_dip(dip: float, back_s: float, again: bool, recovered_s: float) -> None:
    time_s = np.arange(0.0, 500.05, 0.1)
    low = (time_s >= 12.0) & (time_s < back_s)
    if again:
        low |= (time_s >= 300.0) & (time_s < 310.0)
    found = recovery_s(made(min_distance=36.0 - dip * low))
    assert found == pytest.approx(recovered_s, abs=0.2, nan_ok=True)


def test_a_digest_is_read_back(tmp_path: Path) -> None:
    run = replace(made(), facts={"seed": 3, "name": "ä"})
    run.save(tmp_path / "digest.npz")
    again = Digest.read(tmp_path / "digest.npz")
    assert again.facts == run.facts
    assert np.array_equal(again.min_distance, run.min_distance)
    assert np.array_equal(again.link, run.link)
    assert [file.name for file in tmp_path.iterdir()] == ["digest.npz"]


def test_short_runs_leave_later_claims_untested() -> None:
    found = answers(evidence(end_s=20.0))
    untested = {claim.says for claim, answer in found if answer.verdict == "not tested"}
    assert untested == {claim.says for claim in CLAIMS if claim.needs_s > 20.0}
    assert len(CLAIMS) - len(untested) >= 2


def test_verdicts_follow_the_figures() -> None:
    """Each rule can confirm its claim, and can reject it."""
    bcm, mbcm, pbcm = (case(model, LARGE_ERROR) for model in ("BCM", "MBCM", "PBCM"))
    speeds = {bcm: {"mean_speed": 25.0}, mbcm: {"mean_speed": 18.0}}
    assert verdict(evidence(speeds), "Speeds settle at about 25") == "confirmed"
    assert verdict(evidence(), "Speeds settle at about 25") == "not confirmed"

    ends = {bcm: {"min_distance": 31.0}, mbcm: {"min_distance": 33.0}}
    assert verdict(evidence(ends), "MinDistance settles at about 36") == "confirmed"
    mild = {bcm: {"min_distance": 35.0}, mbcm: {"min_distance": 35.0}}
    assert verdict(evidence(mild), "MinDistance settles at about 36") == "weaker"
    assert verdict(evidence(), "MinDistance settles at about 36") == "not confirmed"

    wide = {bcm: {"spread": 0.23}, pbcm: {"spread": 0.17}}
    assert verdict(evidence(wide), "The spread of speeds") in {"stronger", "weaker"}
    assert verdict(evidence({bcm: {"spread": 0.1}}), "The spread of speeds") == "not confirmed"

    best = {
        case("PBCM", pair): {"min_distance": 37.0, "spread": 0.1, "max_distance": 38.0}
        for pair in PAIRS
    }
    assert verdict(evidence(best), "With errors and delays PBCM") == "confirmed"
    assert verdict(evidence(), "With errors and delays PBCM") == "not confirmed"
    assert verdict(evidence(best), "PBCM has the smallest MaxDistance") == "confirmed"
    assert verdict(evidence(), "PBCM has the smallest MaxDistance") == "not confirmed"


def test_every_claim_has_a_row() -> None:
    page = claims_page(evidence(), ["Made up."])
    rows = [line for line in page.splitlines() if line.startswith("| ")][1:]
    assert len(rows) == len(CLAIMS)
    assert all(row.count(" | ") == 4 for row in rows)


def of_gains(*differences: float, end_s: float = 120.0) -> Evidence:
    """Return runs whose MinDistance is that of the worse model plus a difference for each seed."""
    runs = {}
    for one in GAINS:
        for model in MODELS:
            better = model in {"PBCM", "BCM"}
            runs[one.label(model)] = tuple(
                made(seed, end_s, min_distance=30.0 + 5.0 * seed + (more if better else 0.0))
                for seed, more in enumerate(differences)
            )
    return Evidence(runs=runs)


@pytest.mark.parametrize(
    ("differences", "holds"),
    [
        ((0.5, 0.6, 0.7), "yes"),
        ((-0.5, -0.6, -0.7), "no"),
        ((0.5, -0.4, 0.1), "open"),
        ((0.5,), "yes"),
        ((-0.5,), "no"),
    ],
)
def test_an_ordering_is_judged_seed_by_seed(differences: tuple[float, ...], holds: str) -> None:
    """Seeds differ by far more than models."""
    sheet = gains.sheet(of_gains(*differences))
    assert {row[-2:] for row in sheet.rows} == {(holds, holds)}
    assert ("seed 1" in sheet.note) == (len(differences) == 1)


def test_runs_that_end_before_leave_an_ordering_untested() -> None:
    sheet = gains.sheet(of_gains(0.5, 0.6, end_s=30.0))
    assert {row[-2:] for row in sheet.rows} == {("unknown", "unknown")}


def test_fm_is_string_stable_if_linear_theory_says_so() -> None:
    """The reference is the largest gain between vehicles over a grid of frequencies."""
    w = np.geomspace(1e-4, 1e2, 20_000)
    for one in GAINS:
        ahead = one.k_d + one.k_v * 1j * w
        largest = np.abs(ahead / ((1j * w) ** 2 + (one.k_v + one.k_c) * 1j * w + one.k_d)).max()
        assert one.fm_string_stable == (largest <= 1.0 + 1e-12), one
