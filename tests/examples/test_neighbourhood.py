"""The study of filters for the whole neighbourhood, in examples/neighbourhood."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

import zenvoy
from examples.neighbourhood.__main__ import VARIANTS, scenarios
from examples.neighbourhood.chain import Filters, Model
from examples.neighbourhood.hosts import Variant
from examples.neighbourhood.ring import run
from zenvoy.vehicles.estimator import Filter

ROOT: Final = Path(__file__).parents[2]
T_S: Final = 0.1
ALWAYS: Final = np.array([True])


def start(reach: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.zeros(4 * reach + 1)


def test_a_chain_agrees_with_filterpy() -> None:
    model, random = Model.of(2, T_S, coupled=True), np.random.default_rng(1)
    filters = Filters(model, start(2), 10.0, 1)
    rows = [
        *(model.gap(link) for link in range(4)),
        *(model.relative_speed(link) for link in range(4)),
        *(model.speed(vehicle) for vehicle in range(5)),
    ]
    other = KalmanFilter(dim_x=9, dim_z=len(rows), dim_u=5)
    other.x, other.P = np.zeros((9, 1)), 100.0 * np.eye(9)
    other.F, other.B, other.H = model.F, model.B, np.array(rows)
    other.R = 4.0 * np.eye(len(rows))
    for _ in range(30):
        a, variance, z = random.normal(size=5), random.uniform(size=5), random.normal(size=13)
        other.Q = np.einsum("j,jik->ik", variance, model.Q)
        other.predict(u=a[:, None])
        other.update(z)
        filters.predict(a[None], variance[None])
        for h, value in zip(rows, z, strict=True):
            filters.read(h, np.array([value]), 4.0, ALWAYS)
    assert filters.x[0] == pytest.approx(other.x.ravel())
    assert filters.P[0] == pytest.approx(other.P)


def test_without_coupling_each_link_has_the_filter_of_zenvoy() -> None:
    model, random = Model.of(1, T_S, coupled=False), np.random.default_rng(2)
    filters, link = Filters(model, start(1), 1e3, 1), Filter(T_S, 0.5)
    for cycle in range(50):
        a, z = random.normal(size=3), random.normal(size=2)
        filters.predict(a[None], np.full((1, 3), 0.125))
        filters.read(model.gap(1), z[:1], 4.0, ALWAYS)
        filters.read(model.relative_speed(1), z[1:], 3.0, ALWAYS)
        link.step((a[1] - a[2],) if cycle else (), (z[0], z[1]), (4.0, 3.0))
    assert filters.x[0, [1, 3]] == pytest.approx(link.x, abs=1e-3)
    assert filters.P[0][np.ix_([1, 3], [1, 3])] == pytest.approx(link.P, abs=1e-4)
    assert filters.P[0][1, [0, 2, 4]] == pytest.approx([0.0, 0.0, 0.0])


@pytest.mark.parametrize(("coupled", "told"), [(True, True), (False, False)])
def test_only_a_chain_learns_of_an_unheard_vehicle_from_the_one_behind_it(
    coupled: bool, told: bool
) -> None:
    """Vehicle 3 of the chain brakes unheard; vehicle 4 sees it, and the host is vehicle 2."""
    filters = Filters(model := Model.of(2, T_S, coupled=coupled), start(2), 0.1, 1)
    variance = np.array([[0.0, 0.0, 0.0, 4.0, 0.0]])
    for cycle in range(1, 21):
        filters.predict(np.zeros((1, 5)), variance)
        filters.read(model.relative_speed(3), np.array([-0.3 * cycle * T_S]), 0.01, ALWAYS)
    opens = filters.x[0, 4 + 2]  # the host moves away from vehicle 3
    assert opens == pytest.approx(0.6 if told else 0.0, abs=0.15)


def test_a_reading_that_is_not_heard_changes_nothing() -> None:
    filters = Filters(model := Model.of(1, T_S, coupled=True), start(1), 1.0, 2)
    filters.read(model.gap(0), np.array([5.0, 5.0]), 1.0, np.array([True, False]))
    assert filters.x[:, 0].tolist() == [2.5, 0.0]
    assert filters.P[:, 0, 0].tolist() == [0.5, 1.0]


def test_with_a_filter_per_link_it_agrees_with_zenvoy(tmp_path: Path) -> None:
    """The readings and losses are the same, so each run agrees, and not only their means."""
    runs = scenarios(bursts=10, seeds=3, duration_s=30.0)
    pbcm = VARIANTS["one filter per link, PBCM without fallback"]
    found, others = run(runs, pbcm), run(runs, Variant(coupled=False, acceleration_std=0.25))
    for at, one in enumerate(runs):
        done = zenvoy.run(
            zenvoy.scenario(
                "paper/case-15",
                seed=one.seed,
                duration_s=30.0,
                control={"schedule": [], "model": "PBCM", "beacon_age_limit_ms": 1e6},
                events=[],
                channel={"loss": {"gilbert_elliott": {"p": 0.3 / 7.0, "r": 0.1}}},
            ),
            engine="arrays",
            out=tmp_path / str(at),
        )
        rms_m = done.summary["gap_error_rms_m"]
        assert found.gap_error_rms_m[at] == pytest.approx(rms_m, rel=0.02)
        assert others.gap_error_rms_m[at] != pytest.approx(rms_m, rel=0.02)
        assert found.smallest_gap_m[at] == pytest.approx(done.summary["smallest_gap_m"], abs=0.25)


def test_both_ends_of_a_shared_link_act_alike_when_nothing_is_lost() -> None:
    runs = scenarios(bursts=0, seeds=2, duration_s=5.0)
    for name in ("one filter per link, shared", "chain of 2, shared"):
        assert run(runs, VARIANTS[name]).unbalanced_mps2 == pytest.approx([0.0, 0.0], abs=1e-9)
    assert (run(runs, Variant(reach=2)).unbalanced_mps2 > 0.01).all()


def test_it_prints_a_row_for_each_variant() -> None:
    command = [sys.executable, "-m", "examples.neighbourhood"]
    options = ["--seeds", "2", "--duration", "1", "--only", "shared"]
    done = subprocess.run(
        [*command, *options], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    names = [line.split(" | ")[0].removeprefix("| ") for line in done.stdout.splitlines()[2:]]
    assert names == [name for name in VARIANTS if "shared" in name]
