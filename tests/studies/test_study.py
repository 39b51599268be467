"""Studies run their cells, keep digests, and run nothing twice."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import run, zenvoy
from zenvoy.analysis import load
from zenvoy.analysis.measures.digest import Digest, digest
from zenvoy.fleet.engine import ENGINES, Engine
from zenvoy.scenarios import ScenarioError
from zenvoy.studies.cell import Cell, grid
from zenvoy.studies.paper import plan
from zenvoy.studies.study import Study

SMALL = ("fleet.size=8", "events.0.at_s=0.5")
BCM = Cell(scenario="paper/case-07", seed=2, settings=SMALL, duration_s=2.0)
PBCM = Cell(scenario="paper/case-15", seed=2, settings=SMALL, duration_s=2.0)


def test_a_key_depends_on_all_that_is_run() -> None:
    same = Cell(
        scenario="paper/case-15",
        seed=2,
        settings=(*SMALL, "control.schedule.0.model=BCM"),
        duration_s=2.0,
    )
    assert BCM.key() == same.key() != PBCM.key()
    others = [
        Cell(scenario="paper/case-07", seed=3, settings=SMALL, duration_s=2.0),
        Cell(scenario="paper/case-07", seed=2, settings=SMALL, duration_s=3.0),
        Cell(scenario="paper/case-07", seed=2, settings=SMALL[:1], duration_s=2.0),
    ]
    assert len({cell.key() for cell in [BCM, *others]}) == 4


def in_a_process_of_its_own(folder: Path, engine: Engine) -> str:
    """Run BCM and PBCM, and return the first line of output.

    The process of the tests may have opened a Zenoh session, after which it cannot fork a fleet.
    """
    script = f"""if True:
        from pathlib import Path
        from zenvoy.studies.cell import Cell
        from zenvoy.studies.study import Study
        Study(folder=Path({str(folder)!r}), engine={engine!r}, jobs=2, on_line=print).run(
            [{BCM!r}, {PBCM!r}]
        )
    """
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.partition("\n")[0]


@pytest.mark.parametrize("engine", ENGINES)
def test_digests_equal_those_of_the_logs(tmp_path: Path, engine: Engine) -> None:
    assert in_a_process_of_its_own(tmp_path / "runs", engine) == "2 runs, 0 of them done already"
    reported: list[str] = []
    found = Study(folder=tmp_path / "runs", on_line=reported.append).run([BCM, PBCM])
    assert reported == ["2 runs, 2 of them done already"]
    for cell in (BCM, PBCM):
        text = f"extends: {cell.scenario}\nduration_s: 2\nseed: 2\nfleet: {{size: 8}}\nevents:\n"
        text += "  - {vehicle: 5, at_s: 0.5, duration_s: 2, deceleration_mps2: 3}\n"
        folder = tmp_path / cell.scenario[-7:]
        log = run(folder, text, "--bus", "in-process")
        fingerprint = "" if engine == "arrays" else log.result["fingerprint"]
        assert found[cell].facts["fingerprint"] == fingerprint
        expected = digest(load(folder / "out" / "run.mcap"))
        assert np.array_equal(found[cell].min_distance, expected.min_distance)
        assert np.array_equal(found[cell].link, expected.link, equal_nan=True)
        assert found[cell].facts["fit"] == expected.facts["fit"]
    kept = [file for file in (tmp_path / "runs").rglob("*") if file.is_file()]
    assert {file.name for file in kept} == {"digest.npz"}  # and no log


def test_finished_runs_are_not_run_again(tmp_path: Path) -> None:
    first = Study(folder=tmp_path, jobs=2).run([BCM])
    made_ns = {file: file.stat().st_mtime_ns for file in tmp_path.rglob("digest.npz")}
    half = tmp_path / PBCM.key()
    half.mkdir()
    (half / "run.mcap").write_bytes(b"half a log of a run that was stopped")
    reported: list[str] = []
    again = Study(folder=tmp_path, jobs=2, on_line=reported.append).run([BCM, PBCM])
    assert reported == [
        "2 runs, 1 of them done already",
        "engine: arrays",
        f"1 of 1: {_named(PBCM)}",
    ]
    assert again[BCM].facts == first[BCM].facts
    for file, at_ns in made_ns.items():
        assert file.stat().st_mtime_ns == at_ns
    assert [file.name for file in half.iterdir()] == ["digest.npz"]


def test_a_broken_digest_is_made_again(tmp_path: Path) -> None:
    whole = Study(folder=tmp_path, jobs=1).run([BCM])[BCM]
    (file,) = tmp_path.rglob("digest.npz")
    file.write_bytes(file.read_bytes()[:1_000])
    again = Study(folder=tmp_path, jobs=1).run([BCM])[BCM]
    assert again.facts["smallest_gap_m"] == whole.facts["smallest_gap_m"]
    assert Digest.read(file).facts["seed"] == 2


def test_fingerprints_are_made_on_request(tmp_path: Path) -> None:
    in_process = Study(folder=tmp_path / "a", engine="in-process").run([BCM, PBCM])
    without = Study(folder=tmp_path / "b").run([BCM, PBCM])
    assert {run.facts["fingerprint"] for run in without.values()} == {""}
    reported: list[str] = []
    study = Study(folder=tmp_path / "b", fingerprints=True, on_line=reported.append)
    found = study.run([BCM, PBCM])
    assert reported[0] == "2 runs, 0 of them done already"
    for cell, one in in_process.items():
        assert found[cell].facts["fingerprint"] == one.facts["fingerprint"]
    study.run([BCM, PBCM])
    assert reported[-1] == "2 runs, 2 of them done already"


def test_cells_that_arrays_do_not_run_go_in_process(tmp_path: Path) -> None:
    relayed = Cell(
        scenario="paper/case-07",
        seed=2,
        settings=(*SMALL, "channel.relay_hops=2"),
        duration_s=2.0,
    )
    reported: list[str] = []
    found = Study(folder=tmp_path, on_line=reported.append).run([BCM, relayed])
    assert reported[2].startswith(f"{_named(relayed)}: in-process, for channel.relay_hops: 2")
    assert found[relayed].facts["fingerprint"]  # of its log
    assert not found[BCM].facts["fingerprint"]


def test_runs_that_differ_only_in_seed_go_together(tmp_path: Path) -> None:
    of_seeds = [replace(cell, seed=seed) for seed in (1, 2, 3) for cell in (BCM, PBCM)]
    reported: list[str] = []
    found = Study(folder=tmp_path, on_line=reported.append).run(of_seeds)
    together = [line.partition(": ")[2] for line in reported[2:]]
    by_scenario = sorted(of_seeds, key=lambda cell: cell.scenario)
    assert sorted(together) == sorted(_named(cell) for cell in of_seeds)
    assert together[:3] in (
        [_named(cell) for cell in by_scenario[:3]],
        [_named(cell) for cell in by_scenario[3:]],
    )
    assert [found[cell].facts["seed"] for cell in of_seeds] == [1, 1, 2, 2, 3, 3]


def test_a_list_of_fingerprints_is_not_replaced_by_a_shorter_one(tmp_path: Path) -> None:
    arguments = ["reproduce", "--seeds", "2", "--duration-s", "1", "--out", "r", "--runs", "runs"]
    sheet = tmp_path / "r" / "fingerprints.csv"
    sheet.parent.mkdir()
    sheet.write_text("run,seed,cycles,fingerprint\n01,1,10,abc\n")
    assert zenvoy(tmp_path, *arguments).code == 0
    assert sheet.read_text() == "run,seed,cycles,fingerprint\n01,1,10,abc\n"
    page = tmp_path / "r" / "README.md"
    assert "`fingerprints.csv` holds the fingerprints of earlier runs." in page.read_text()
    assert zenvoy(tmp_path, *arguments, "--fingerprints").code == 0
    rows = sheet.read_text().splitlines()
    assert len(rows) == 1 + 16 * 2 + 16 * 2 + 4 * 2 + 2 + 27 * 4
    assert all(len(row.rpartition(",")[2]) == 64 for row in rows[1:])
    assert "lists the fingerprint of every run" in page.read_text()


def test_a_wrong_cell_is_reported_before_any_cell_runs(tmp_path: Path) -> None:
    wrong = Cell(scenario="paper/case-15", seed=1, settings=("fleet.size=1",))
    with pytest.raises(ScenarioError, match=r"fleet\.size: 1 is not in"):
        Study(folder=tmp_path, jobs=1).run([BCM, wrong])
    assert list(tmp_path.iterdir()) == []


def test_a_grid_goes_seed_by_seed() -> None:
    cells = grid(["a", "b"], [1, 2], ("x=1",))
    assert [(cell.scenario, cell.seed) for cell in cells] == [
        ("a", 1),
        ("b", 1),
        ("a", 2),
        ("b", 2),
    ]


def test_the_plan_has_all_cases_on_both_roads() -> None:
    cells = plan(30, None)
    for number in range(1, 17):
        label = f"{number:02}"
        assert [cell.seed for cell in cells[label]] == list(range(1, 31))
        assert {cell.scenario for cell in cells[label]} == {f"paper/case-{label}"}
        assert len(cells[f"open/{label}"]) == 5
        assert cells[f"open/{label}"][0].load().scenario.road.type == "open"
    gains = [of_label for label, of_label in cells.items() if label.startswith("gains/")]
    assert len(gains) == 27 * 4
    assert {len(of_label) for of_label in gains} == {3}
    for of_label in cells.values():
        of_label[0].load()


def test_supplements_of_the_cases_have_a_tenth_of_many_seeds() -> None:
    cells = plan(300, None)
    lengths = {label.partition("/")[0]: len(of_label) for label, of_label in cells.items()}
    assert lengths["15"] == 300
    assert {lengths[part] for part in ("open", "stale", "sign", "gains")} == {30}


def test_reproduce_writes_tables_figures_and_claims(tmp_path: Path) -> None:
    """Runs of one second make the whole report, without claims on times that they do not reach."""
    arguments = ["reproduce", "--seeds", "2", "--duration-s", "1", "--out", "r", "--runs", "runs"]
    outcome = zenvoy(tmp_path, *arguments)
    assert (outcome.code, outcome.err) == (0, ""), outcome
    out = tmp_path / "r"
    names = {file.name for file in out.iterdir()}
    pictures = {"error-reduction", "velocity-snapshots", "heat-maps", "min-distance", "gains"}
    assert {f"{name}.{form}" for name in pictures for form in ("png", "svg")} <= names
    assert {"README.md", "claims.md", "table-6.csv", "cases.csv", "cases-open.csv"} <= names
    assert "fingerprints.csv" not in names
    claims = (out / "claims.md").read_text()
    assert "zenvoy reproduce --seeds 2 --engine arrays --duration-s 1" in claims
    assert claims.count("**not tested**") >= 15
    before = {file.name: file.read_bytes() for file in out.iterdir()}
    again = zenvoy(tmp_path, *arguments)
    assert "runs, 182 of them done already" in again.out
    assert {file.name: file.read_bytes() for file in out.iterdir()} == before


def _named(cell: Cell) -> str:
    return " ".join((cell.scenario, f"seed {cell.seed}", *cell.settings))
